#pragma once

// Private to the tsdf_*.cpp and vdb_*.cpp files: the only header that includes OpenVDB.

#include <openvdb/openvdb.h>

#include "core/volume/tsdf_grid.h"

namespace steadymap {

using WordTree = openvdb::tree::Tree3<openvdb::Int32, 3, 3>::Type;

/// The trees of one volume. `voxels` has the bits of `Voxel`; observed voxels are active. `color`
/// has a leaf wherever colour was recorded. Inactive voxels are zero.
struct TsdfGrid::Trees {
  WordTree voxels{0};
  WordTree color{0};
};

using LeafNodeMask = openvdb::util::NodeMask<3>;

inline LeafNodeMask ToNodeMask(const LeafMask& mask) {
  LeafNodeMask node_mask;
  for (int word = 0; word < kLeafSide; ++word) {
    node_mask.getWord<std::uint64_t>(static_cast<openvdb::Index>(word)) =
        mask[static_cast<std::size_t>(word)];
  }
  return node_mask;
}

inline openvdb::Coord ToCoord(LeafOrigin origin) { return {origin.x, origin.y, origin.z}; }

}  // namespace steadymap
