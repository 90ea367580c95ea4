#include "client/cli/text/argument_text.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include <absl/strings/numbers.h>
#include <absl/strings/str_split.h>
#include <absl/time/time.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::size_t kNanosecondDigits = 9;

// The range of 64-bit nanoseconds ends in 2262.
const absl::Time kFirstMoment = absl::UnixEpoch();
const absl::Time kLastMoment = absl::FromUnixSeconds(9'214'646'400);

// Parses exactly `count` finite numbers separated by commas; none for any other text.
std::optional<std::vector<double>> ParseNumbers(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  const char* place = text.data();
  const char* const end = place + text.size();
  while (numbers.size() < count) {
    double number = 0.0;
    const std::from_chars_result parsed = std::from_chars(place, end, number);
    if (parsed.ec != std::errc() || !std::isfinite(number)) return std::nullopt;
    numbers.push_back(number);
    place = parsed.ptr;
    if (numbers.size() == count) break;
    if (place == end || *place != ',') return std::nullopt;
    ++place;
  }
  if (place != end) return std::nullopt;
  return numbers;
}

// Parses seconds since 1970 as a decimal number, with the exact result of the equal RFC 3339 text;
// none for any other text.
std::optional<absl::Time> ParseSeconds(std::string_view text) {
  const std::size_t point = text.find('.');
  const std::string_view whole = text.substr(0, point);
  std::string fraction(point == std::string_view::npos ? "" : text.substr(point + 1));
  const auto is_number = [](std::string_view digits) {
    return !digits.empty() && digits.find_first_not_of("0123456789") == std::string_view::npos;
  };
  if (!is_number(whole) || (point != std::string_view::npos && !is_number(fraction))) {
    return std::nullopt;
  }
  fraction.resize(kNanosecondDigits, '0');
  std::int64_t seconds = 0;
  std::int64_t nanoseconds = 0;
  if (std::from_chars(whole.data(), whole.data() + whole.size(), seconds).ec != std::errc()) {
    return std::nullopt;
  }
  std::from_chars(fraction.data(), fraction.data() + fraction.size(), nanoseconds);
  return absl::FromUnixSeconds(seconds) + absl::Nanoseconds(nanoseconds);
}

absl::Status Expected(const char* what, std::string_view found) {
  return absl::InvalidArgumentError(std::string("expected ") + what + ", got \"" +
                                    std::string(found) + "\"");
}

}  // namespace

absl::StatusOr<MapName> ParseMapArgument(std::string_view text) {
  if (text.find('/') != std::string_view::npos) return MapName::Parse(text);
  if (IsValidId(text)) return MapName{"default", std::string(text)};
  return Expected(
      "a map name (lower-case letters, digits and hyphens, starting with a letter, at most 63 "
      "characters) or tenants/{tenant}/maps/{map}",
      text);
}

absl::StatusOr<Eigen::Vector3d> ParsePoint(std::string_view text) {
  const std::optional<std::vector<double>> numbers = ParseNumbers(text, 3);
  if (!numbers) return Expected("a point x,y,z in metres", text);
  return Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

absl::StatusOr<Box> ParseBox(std::string_view text) {
  const std::optional<std::vector<double>> numbers = ParseNumbers(text, 6);
  if (!numbers) return Expected("a box x0,y0,z0,x1,y1,z1 in metres", text);
  const Box box(Eigen::Vector3d((*numbers)[0], (*numbers)[1], (*numbers)[2]),
                Eigen::Vector3d((*numbers)[3], (*numbers)[4], (*numbers)[5]));
  if (box.isEmpty()) return Expected("a box with the lowest corner first", text);
  return box;
}

absl::StatusOr<Timestamp> ParseTime(std::string_view text) {
  std::optional<absl::Time> moment = ParseSeconds(text);
  absl::Time parsed;
  std::string ignored;
  if (!moment && absl::ParseTime(absl::RFC3339_full, std::string(text), &parsed, &ignored)) {
    moment = parsed;
  }
  if (!moment || *moment < kFirstMoment || *moment >= kLastMoment) {
    return Expected("a time such as 2024-05-01T12:00:00Z, or seconds since 1970", text);
  }
  return Timestamp::FromNanoseconds(absl::ToUnixNanos(*moment));
}

absl::StatusOr<std::map<std::string, std::string>> ParseLabels(
    const std::vector<std::string>& texts) {
  std::map<std::string, std::string> labels;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) return Expected("a label KEY=VALUE", text);
    if (!labels.emplace(text.substr(0, equals), text.substr(equals + 1)).second) {
      return Expected("each label at most once", text);
    }
  }
  return labels;
}

absl::StatusOr<ParameterValues> ParseParameters(const std::vector<std::string>& texts) {
  ParameterValues parameters;
  for (const std::string& text : texts) {
    const std::pair<std::string, std::string> parts = absl::StrSplit(text, absl::MaxSplits('=', 1));
    double value = 0.0;
    if (parts.first.empty() || !absl::SimpleAtod(parts.second, &value)) {
      return InvalidField(reason::kBadValue,
                          "parameters",
                          "--set needs NAME=VALUE with a number, got \"" + text + "\"");
    }
    parameters[parts.first] = value;
  }
  return parameters;
}

absl::StatusOr<std::array<double, 4>> ParseIntrinsics(std::string_view text) {
  const std::optional<std::vector<double>> numbers = ParseNumbers(text, 4);
  if (!numbers) return Expected("a camera fx,fy,cx,cy in pixels", text);
  return std::array{(*numbers)[0], (*numbers)[1], (*numbers)[2], (*numbers)[3]};
}

}  // namespace steadymap
