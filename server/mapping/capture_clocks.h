#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Compares the capture times of a map's frames with the server's clock, so that a wrong clock of a
/// robot is reported in the log and in `GetUploadState` before it affects the map. Stores a bounded
/// number of sensors; the least recent one is removed. Thread-safe.
class CaptureClocks {
 public:
  /// Frames with a capture time further ahead of the server's clock are refused.
  static constexpr std::chrono::hours kMaxAhead{24};

  /// Maximum number of stored sensors.
  static constexpr std::size_t kMaxSensors = 1000;

  /// `map_name` is used in log lines.
  explicit CaptureClocks(std::string map_name) : map_name_(std::move(map_name)) {}

  /// Records a frame that `sensor` captured at `capture_time` and that arrived at `now`. Logs, once
  /// per sensor, a capture time before the year 2000, more than 10 s ahead of `now`, or more than 1
  /// h before that of an earlier frame; recordings are not checked. Errors: `InvalidArgument` with
  /// reason `BAD_CAPTURE_TIME` and the field `capture_time` if the capture time is more than
  /// `kMaxAhead` ahead of `now`.
  absl::Status Note(const SensorName& sensor,
                    Timestamp capture_time,
                    v1::ClockDomain domain,
                    Timestamp now) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns by how much the capture time of the sensor's last frame was ahead of the server's
  /// clock; none if no frame of the sensor has arrived or the sensor was removed.
  std::optional<std::chrono::nanoseconds> AheadOf(const SensorName& sensor) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Clock {
    std::chrono::nanoseconds ahead{0};
    Timestamp newest;
    bool was_logged = false;
    std::uint64_t heard = 0;  ///< Number of the last call of `Note` for it.
  };

  Clock& FindClock(const SensorName& sensor) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string map_name_;
  mutable absl::Mutex mutex_;
  std::map<SensorName, Clock> clocks_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t notes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace steadymap
