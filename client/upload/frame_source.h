#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// The error of a source that is asked for a frame behind its last.
inline absl::Status NoFrameAt(std::size_t index, std::size_t frame_count) {
  return absl::OutOfRangeError("expected the index of one of " + std::to_string(frame_count) +
                               " frames, got " + std::to_string(index));
}

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

  /// What the call of `Next` number `index`, from 0, gave or would give, the same bytes each time.
  /// `Next` goes on where it was. Errors: as `Next`; `OutOfRange` where that gives the end.
  virtual absl::StatusOr<v1::Frame> Read(std::size_t index) = 0;
};

}  // namespace steadymap
