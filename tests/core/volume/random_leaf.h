#pragma once

#include <random>

#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Random canonical voxels at the default scale: each observed with `probability`, smooth or wild.
LeafVoxels RandomLeaf(std::mt19937* random, double probability, bool smooth, bool color);

}  // namespace steadymap
