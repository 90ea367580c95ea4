#pragma once

// Private to the tsdf_*.cpp and vdb_*.cpp files: the only header that includes OpenVDB.

#include <openvdb/openvdb.h>

#include "core/volume/tsdf_grid.h"

namespace steadymap {

using FloatTree = openvdb::tree::Tree4<float, 3, 3, 3>::Type;
using ColorTree = openvdb::tree::Tree4<openvdb::Int32, 3, 3, 3>::Type;

/// The trees of one volume. `distance` and `weight` have the same leaves with the same active
/// voxels. `color` has a leaf wherever colour was recorded. Inactive voxels are zero.
struct TsdfGrid::Trees {
  FloatTree distance{0.0F};
  FloatTree weight{0.0F};
  ColorTree color{0};
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
