#pragma once

#include "core/volume/voxel_leaf.h"

namespace steadymap::testing {

/// The default scale of a map.
inline constexpr VoxelScale kScale;

}  // namespace steadymap::testing
