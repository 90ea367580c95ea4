#pragma once

#include <cstddef>

#include <absl/status/statusor.h>

#include "core/frame/frame.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// Decodes and validates a frame. `source` is the sensor; `labels` are the classes that label
/// images of the map may hold. Checks the image size of the intrinsics before any allocation; every
/// image must have this size.
///
/// Errors: `InvalidArgument` with a reason of core/types/error.h and the field path relative to the
/// frame, such as `depth.data`. Cost: decoding, 2 to 3 ms for PNG depth and labels of 640 x 360,
/// distributed over free cores. Pure, any thread.
absl::StatusOr<Frame> FromProto(const v1::Frame& message,
                                const SensorName& source,
                                const KnownLabels& labels);

/// Memory of the decoded images of a frame, bytes, from the image size of its intrinsics. At most
/// that of the largest permitted images, for any input.
std::size_t DecodedBytes(const v1::Frame& message);

/// The camera of a frame. Errors: those of `ValidateCamera`, with the field of the message.
absl::StatusOr<PinholeCamera> FromProto(const v1::CameraIntrinsics& message);
v1::CameraIntrinsics ToProto(const PinholeCamera& camera);

}  // namespace steadymap
