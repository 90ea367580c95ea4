#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <absl/status/status.h>

#include "core/types/timestamp.h"

namespace steadymap {

/// Properties of some frames of a recording, used to detect a wrong unit or wrong times.
struct RecordingSample {
  std::size_t frame_count = 0;  ///< Number of frames with readable depth.
  /// Median over all sampled pixels with depth; none without such pixels.
  std::optional<double> median_depth_m;
  double metres_per_unit = 0.0;  ///< Unit with which the depth of the first frame was read.
  Timestamp first_time;          ///< Time of the recording's first frame.
};

/// Checks that the depth is plausible for a robot: its median is within [5 cm, 100 m]. A sample
/// without frames is OK. Errors: `InvalidArgument` with the median in the message, or with the
/// statement that no pixel has depth. If `has_unit`, the user can change the unit, and the message
/// recommends it.
absl::Status CheckDepth(const RecordingSample& sample, bool has_unit);

/// Returns a warning for the user if the recording's times start before 2000, as with a clock that
/// was never set; none otherwise.
std::optional<std::string> NoteOnTimes(const RecordingSample& sample);

}  // namespace steadymap
