#pragma once

#include <filesystem>

#include <absl/status/status.h>

#include "core/geometry/geometry.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// The unit to which depth in metres is rounded: 0.2 mm. Rounding is then far below the resolution
/// of any sensor, and 16 bits reach 13.1 m, far beyond the fused depth.
inline constexpr double kMetresPerUnitOfFloatDepth = 0.0002;

/// Packs a depth image into `message`. The image must have the size of the camera's images.
///
/// A 16-bit PNG file is copied unchanged. A file with the extension `.exr`, `.tif` or `.tiff`
/// contains metres, which are rounded to units. NaN, infinity, values that are not positive and
/// values beyond 16 bits become 0, which means no return. Errors: `NotFound` or `InvalidArgument`,
/// with the file in the message.
absl::Status PackDepthFile(const std::filesystem::path& file,
                           const PinholeCamera& camera,
                           double metres_per_unit,
                           v1::DepthImage* message);

}  // namespace steadymap
