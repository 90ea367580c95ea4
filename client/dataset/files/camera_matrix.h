#pragma once

#include <filesystem>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"

namespace steadymap {

/// The camera of a sequence: `fallback`, or, where `folder` holds a `camera-intrinsics.txt` with a
/// 3x3 camera matrix, that one with the image size of `first_depth`.
/// Errors: `InvalidArgument` or `NotFound` naming the file.
absl::StatusOr<PinholeCamera> CameraOfSequence(const std::filesystem::path& folder,
                                               const std::filesystem::path& first_depth,
                                               const PinholeCamera& fallback);

}  // namespace steadymap
