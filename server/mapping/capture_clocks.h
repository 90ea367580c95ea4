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

/// Compares the clocks that a map's frames are stamped with to the server's: a robot whose clock is
/// wrong is found in the log and in `GetUploadState` before it is found in the map. Of
/// very many sensors, the one that was heard of longest ago is forgotten. Thread-safe.
class CaptureClocks {
 public:
  /// Frames that lie further ahead are refused.
  static constexpr std::chrono::hours kMaxAhead{24};

  /// Sensors that are remembered.
  static constexpr std::size_t kMaxSensors = 1000;

  /// `map_name` is for the log.
  explicit CaptureClocks(std::string map_name) : map_name_(std::move(map_name)) {}

  /// Notes a frame that `sensor` took at `capture_time` and that came at `now`. Logs, once a
  /// sensor, times before the year 2000, more than ten seconds ahead, or an hour before those of an
  /// earlier frame; none of a recording. Errors: `InvalidArgument` with reason `BAD_CAPTURE_TIME`
  /// and the field `capture_time` for one more than `kMaxAhead` ahead.
  absl::Status Note(const SensorName& sensor,
                    Timestamp capture_time,
                    v1::ClockDomain domain,
                    Timestamp now) ABSL_LOCKS_EXCLUDED(mutex_);

  /// How far the sensor's clock was ahead of the server's at its newest frame; none before one
  /// came, or once the sensor was forgotten.
  std::optional<std::chrono::nanoseconds> AheadOf(const SensorName& sensor) const
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Clock {
    std::chrono::nanoseconds ahead{0};
    Timestamp newest;
    bool was_logged = false;
    std::uint64_t heard = 0;  ///< Number of the note that was the last of it.
  };

  Clock& FindClock(const SensorName& sensor) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string map_name_;
  mutable absl::Mutex mutex_;
  std::map<SensorName, Clock> clocks_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t notes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace steadymap
