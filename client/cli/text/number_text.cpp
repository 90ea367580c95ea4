#include "client/cli/text/number_text.h"

#include <array>
#include <cmath>

#include <absl/strings/str_format.h>
#include <absl/time/time.h>

namespace steadymap {

std::string LengthText(double length_m) {
  const double magnitude_m = std::abs(length_m);
  if (magnitude_m >= 1.0 || magnitude_m == 0.0) return absl::StrFormat("%.4g m", length_m);
  if (magnitude_m >= 0.01) return absl::StrFormat("%.4g cm", length_m * 1e2);
  return absl::StrFormat("%.3g mm", length_m * 1e3);
}

std::string BytesText(std::uint64_t bytes) {
  constexpr std::array<const char*, 5> kUnits = {"B", "KiB", "MiB", "GiB", "TiB"};
  if (bytes < 1024) return absl::StrFormat("%d B", bytes);
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  while (value >= 1024.0 && unit + 1 < kUnits.size()) {
    value /= 1024.0;
    ++unit;
  }
  return absl::StrFormat("%.*f %s", value < 100.0 ? 1 : 0, value, kUnits.at(unit));
}

std::string CountText(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t place = 3; place < digits.size(); place += 4) {
    digits.insert(digits.size() - place, 1, ' ');
  }
  return digits;
}

std::string DurationText(double seconds) {
  if (seconds < 10.0) return absl::StrFormat("%.2f s", seconds);
  if (seconds < 60.0) return absl::StrFormat("%.1f s", seconds);
  const auto whole = static_cast<std::uint64_t>(seconds);
  return absl::StrFormat("%d min %02d s", whole / 60, whole % 60);
}

std::string TimeText(const google::protobuf::Timestamp& moment) {
  return absl::FormatTime(
      "%Y-%m-%dT%H:%M:%E*SZ",
      absl::FromUnixSeconds(moment.seconds()) + absl::Nanoseconds(moment.nanos()),
      absl::UTCTimeZone());
}

std::string FixedText(double value, int decimals) {
  std::string text = absl::StrFormat("%.*f", decimals, value);
  if (text.find_first_not_of("-0.") == std::string::npos && text.front() == '-') text.erase(0, 1);
  return text;
}

}  // namespace steadymap
