#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Index in the volume of the voxel at `offset` of the leaf at `origin`; times the voxel size it is
/// the voxel's centre. Apart from `voxel_leaf.h`, which the vectorised kernels include: Eigen's
/// inline functions must not be compiled for other processors than the rest of the program.
inline Eigen::Vector3i VoxelIndexAt(LeafOrigin origin, std::size_t offset) {
  return {origin.x + static_cast<int>(offset >> 6),
          origin.y + static_cast<int>((offset >> 3) & 7),
          origin.z + static_cast<int>(offset & 7)};
}

}  // namespace steadymap
