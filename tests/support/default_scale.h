#pragma once

#include "core/volume/voxel_leaf.h"

namespace steadymap::testing {

/// The scale of a map that does not say otherwise.
inline constexpr VoxelScale kScale;

}  // namespace steadymap::testing
