#pragma once

#include <random>

#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Returns random voxels. Each voxel is observed with `probability`.
/// If `smooth`, distances are a noisy linear function of the position, else independent.
LeafVoxels RandomLeaf(std::mt19937* random, double probability, bool smooth, bool color);

}  // namespace steadymap
