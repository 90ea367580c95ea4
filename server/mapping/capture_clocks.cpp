#include "server/mapping/capture_clocks.h"

#include <algorithm>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

// A server clock before this time is not set, so robots' clocks are not compared with it.
constexpr Timestamp kYear2000 = Timestamp::FromNanoseconds(946'684'800'000'000'000);

constexpr std::chrono::seconds kNotableAhead{10};
constexpr std::chrono::hours kNotableStepBack{1};

/// Returns `to - from`, saturated at about 292 years.
std::chrono::nanoseconds Between(Timestamp from, Timestamp to) {
  return std::chrono::nanoseconds((to - from).nanoseconds());
}

double SecondsOf(std::chrono::nanoseconds time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

absl::Status CaptureClocks::Note(const SensorName& sensor,
                                 Timestamp capture_time,
                                 v1::ClockDomain domain,
                                 Timestamp now) {
  const std::chrono::nanoseconds ahead = Between(now, capture_time);
  const bool is_live = domain != v1::CLOCK_DOMAIN_RECORDING;
  const bool knows_time = now > kYear2000;
  if (is_live && knows_time && ahead > kMaxAhead) {
    return InvalidField(
        reason::kBadCaptureTime,
        "capture_time",
        absl::StrCat("capture_time is ",
                     SecondsOf(ahead),
                     " s ahead of the server's clock; at most ",
                     SecondsOf(kMaxAhead),
                     " s are allowed; check the clocks of the robot and of the server"));
  }
  std::string notable;
  {
    const absl::MutexLock lock(&mutex_);
    Clock& clock = FindClock(sensor);
    const std::chrono::nanoseconds step_back = Between(capture_time, clock.newest);
    clock.ahead = ahead;
    if (!clock.was_logged && is_live) {
      if (capture_time < kYear2000) {
        notable = "before the year 2000; check that it is set, in nanoseconds";
      } else if (knows_time && ahead > kNotableAhead) {
        notable = absl::StrCat(SecondsOf(ahead), " s ahead of the server's clock");
      } else if (step_back > kNotableStepBack) {
        notable =
            absl::StrCat(SecondsOf(step_back), " s before the capture time of an earlier frame");
      }
      clock.was_logged = !notable.empty();
    }
    clock.newest = std::max(clock.newest, capture_time);
  }
  if (!notable.empty()) {
    spdlog::warn("map {} sensor {}: the capture time of a frame is {}",
                 map_name_,
                 sensor.ToString(),
                 notable);
  }
  return absl::OkStatus();
}

/// Finds or adds the clock of a sensor and marks it as the most recent one. If the table is full,
/// the least recent clock is removed.
CaptureClocks::Clock& CaptureClocks::FindClock(const SensorName& sensor) {
  auto found = clocks_.find(sensor);
  if (found == clocks_.end()) {
    if (clocks_.size() >= kMaxSensors) {
      clocks_.erase(
          std::min_element(clocks_.begin(), clocks_.end(), [](const auto& a, const auto& b) {
            return a.second.heard < b.second.heard;
          }));
    }
    found = clocks_.emplace(sensor, Clock()).first;
  }
  found->second.heard = ++notes_;
  return found->second;
}

std::optional<std::chrono::nanoseconds> CaptureClocks::AheadOf(const SensorName& sensor) const {
  const absl::MutexLock lock(&mutex_);
  const auto clock = clocks_.find(sensor);
  if (clock == clocks_.end()) return std::nullopt;
  return clock->second.ahead;
}

}  // namespace steadymap
