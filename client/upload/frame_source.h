#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Returns the error for an index beyond the last frame of a source.
inline absl::Status NoFrameAt(std::size_t index, std::size_t frame_count) {
  return absl::OutOfRangeError("expected the index of one of " + std::to_string(frame_count) +
                               " frames, got " + std::to_string(index));
}

/// A sequence of frames ready for upload: a recorded data set or the simulator.
///
/// Images keep their recorded packing wherever the wire format supports it, so reading a data set
/// needs no decoding. Not thread-safe: one reader.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Number of frames that `Next` is expected to return, for progress reports. Unusable frames
  /// (e.g. without a pose) can reduce it.
  virtual std::size_t frame_count() const = 0;

  /// Returns the next frame, or none at the end. Errors: a missing, unreadable or malformed file,
  /// named in the message. The next call continues with the following frame.
  virtual absl::StatusOr<std::optional<v1::Frame>> Next() = 0;

  /// Returns the result of call number `index` (from 0) of `Next`, with identical bytes each time.
  /// The position of `Next` does not change. Errors: those of `Next`; `OutOfRange` at or after the
  /// end.
  virtual absl::StatusOr<v1::Frame> Read(std::size_t index) = 0;
};

}  // namespace steadymap
