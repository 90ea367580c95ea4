#pragma once

#include <vector>

#include "core/integration/semantic_cloud.h"
#include "core/volume/background.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Finds the leaves of a background whose surface a frame may see through: leaves in view with a
/// voxel behind a surface, nearer to the camera than a depth measured in their direction by at
/// least the truncation distance. Looks as far as `max_range_m`. The voxels that are really seen
/// through are fewer. Sorted. Cost: about 0.1 us per leaf in view.
std::vector<LeafOrigin> FindSeenThroughLeaves(const SemanticCloud& cloud,
                                              const Background& background,
                                              const VoxelScale& scale,
                                              double max_range_m);

}  // namespace steadymap
