#pragma once

#include <cstddef>
#include <optional>

#include <absl/status/statusor.h>

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// A sequence of frames ready for upload: a recorded data set, or the simulator.
///
/// Images stay packed as they were recorded wherever the wire format knows the packing, so reading
/// a data set costs no decoding. Not thread-safe: one reader.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Frames that `Next` will deliver in all, for progress; frames that turn out to be unusable (no
  /// pose, say) may make it less.
  virtual std::size_t frame_count() const = 0;

  /// The next frame, or none at the end.
  /// Errors: a file that is missing, unreadable or malformed; the message names it. The source goes
  /// on with the frame after it at the next call.
  virtual absl::StatusOr<std::optional<v1::Frame>> Next() = 0;
};

}  // namespace steadymap
