#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <absl/status/status.h>

#include "core/types/timestamp.h"

namespace steadymap {

/// What some frames of a recording show, to see whether it is read as it was meant.
struct RecordingSample {
  std::size_t frame_count = 0;           ///< Frames whose depth could be read.
  std::optional<double> median_depth_m;  ///< Of all their pixels with depth; none without any.
  double metres_per_unit = 0.0;          ///< By which the depth of the first frame was read.
  Timestamp first_time;                  ///< Of the recording's first frame.
};

/// OK if the depth is what a robot may have around it: its median within [5 cm, 100 m]. A sample
/// without frames says nothing, and is OK.
/// Errors: `InvalidArgument` that names the median, or that no pixel has any depth; `has_unit` says
/// whether depth has a unit that the user can change, which the message then names.
absl::Status CheckDepth(const RecordingSample& sample, bool has_unit);

/// A line for the user if the recording's times begin before 2000, as those of clocks that were
/// never set do; else none.
std::optional<std::string> NoteOnTimes(const RecordingSample& sample);

}  // namespace steadymap
