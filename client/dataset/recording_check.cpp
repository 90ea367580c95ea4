#include "client/dataset/recording_check.h"

#include <cstdint>

#include <absl/strings/str_cat.h>
#include <absl/time/time.h>

namespace steadymap {
namespace {

// Plausible range of the median depth for a robot. A unit that is wrong by a factor of 1000, such
// as metres for millimetres, gives a median outside it; a factor of 5 may not.
constexpr double kMinMedianDepthM = 0.05;
constexpr double kMaxMedianDepthM = 100.0;

constexpr std::int64_t kYear2000Ns = 946'684'800'000'000'000;

std::string UnitHint(const RecordingSample& sample, bool has_unit) {
  if (!has_unit) return "; the depth files of this format hold metres";
  return absl::StrCat(
      ", read at ",
      sample.metres_per_unit,
      " m per unit; set the unit with --depth-scale, for example 0.001 for millimetres or "
      "0.0002 for 5000 units per metre");
}

}  // namespace

absl::Status CheckDepth(const RecordingSample& sample, bool has_unit) {
  if (sample.frame_count == 0) return absl::OkStatus();
  if (!sample.median_depth_m) {
    return absl::InvalidArgumentError(
        absl::StrCat("no pixel of the ",
                     sample.frame_count,
                     " sampled frames has any depth",
                     has_unit ? ": all are 0 or 65535"
                              : " within 13 m; the depth files of this format hold metres"));
  }
  const double median_m = *sample.median_depth_m;
  if (median_m >= kMinMedianDepthM && median_m <= kMaxMedianDepthM) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("expected depth with a median in [",
                                                 kMinMedianDepthM,
                                                 ", ",
                                                 kMaxMedianDepthM,
                                                 "] m, found ",
                                                 median_m) +
                                    " m" + UnitHint(sample, has_unit));
}

std::optional<std::string> NoteOnTimes(const RecordingSample& sample) {
  const std::int64_t ns = sample.first_time.nanoseconds();
  if (sample.frame_count == 0 || ns >= kYear2000Ns) return std::nullopt;
  return absl::StrCat(
      "warning: the recording begins at ",
      absl::FormatTime("%Y-%m-%dT%H:%M:%E*SZ", absl::FromUnixNanos(ns), absl::UTCTimeZone()),
      ", before 2000: the map's objects and events will have times of that year, and frames of "
      "robots with correct clocks will be much later");
}

}  // namespace steadymap
