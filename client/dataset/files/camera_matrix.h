#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"

namespace steadymap {

/// Returns the camera of a sequence. If `folder` contains a `camera-intrinsics.txt` with a 3x3
/// camera matrix, the result is that camera with the image size of `first_depth`; otherwise
/// `fallback`. Errors: `InvalidArgument` or `NotFound`, with the file in the message.
absl::StatusOr<PinholeCamera> CameraOfSequence(const std::filesystem::path& folder,
                                               const std::filesystem::path& first_depth,
                                               const PinholeCamera& fallback);

}  // namespace steadymap
