#pragma once

#include <string>

#include <absl/status/statusor.h>

#include "core/geometry.h"
#include "core/map_snapshot.h"

namespace steadymap {

/// A map as an OpenVDB 10 file: stock float grids `background/distance` and `background/weight`,
/// and `background/color` (Vec3f, 0 to 1) where colour was recorded. Grid metadata: `class`,
/// `revision`, `voxel_size_m`, `truncation_m`. Equal maps give equal bytes.
///
/// `box`, where given, keeps the voxels whose centre lies within it.
/// Errors: `Internal` where OpenVDB fails.
absl::StatusOr<std::string> WriteVdb(const MapSnapshot& snapshot, const Box* box);

}  // namespace steadymap
