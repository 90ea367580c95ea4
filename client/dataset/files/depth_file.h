#pragma once

#include <filesystem>

#include <absl/status/status.h>

#include "core/geometry/geometry.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// The unit that depth in metres is rounded to: a fifth of a millimetre, so that rounding is far
/// below what any sensor resolves, and 16 bits reach 13.1 m, far beyond what is fused.
inline constexpr double kMetresPerUnitOfFloatDepth = 0.0002;

/// Packs a depth image that must be as large as the camera says into `message`.
///
/// A 16-bit PNG file passes as it lies. What ends in `.exr`, `.tif` or `.tiff` holds metres, which
/// are rounded to units; NaN, infinity, and what is not positive or beyond 16 bits become 0, no
/// return.
/// Errors: `NotFound` or `InvalidArgument`, naming the file.
absl::Status PackDepthFile(const std::filesystem::path& file,
                           const PinholeCamera& camera,
                           double metres_per_unit,
                           v1::DepthImage* message);

}  // namespace steadymap
