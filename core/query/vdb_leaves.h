#pragma once

#include <vector>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/map/placed_volume.h"
#include "core/types/cancellation.h"
#include "core/volume/voxel_leaf.h"

/// Private to the vdb files: which voxels of a volume a file holds.
namespace steadymap {

/// A leaf of a grid and those of its voxels that the grid has, at least one.
struct MaskedLeaf {
  LeafOrigin origin;
  LeafMask mask{};
};

/// The leaves of a volume's grids, each list in the order in which a stock OpenVDB tree (nodes of
/// 4096, 128 and 8 voxels a side) holds them.
struct VdbLeaves {
  std::vector<MaskedLeaf> observed;  ///< Of distance and weight.
  std::vector<MaskedLeaf> colored;   ///< Of the observed voxels, those with a colour.
};

/// What a file holds of a volume: all that was observed, or what of it has its voxel's centre in
/// `box_world`, where given. Cost: 0.1 us a leaf, with a box 5 us each leaf that touches it.
/// Errors: `Cancelled`.
absl::StatusOr<VdbLeaves> ChooseVdbLeaves(const PlacedVolume& volume,
                                          const VoxelScale& scale,
                                          const Box* box_world,
                                          const Cancellation& cancellation);

/// Whether `ChooseVdbLeaves` would find a coloured voxel. Ends at the first. Errors: `Cancelled`.
absl::StatusOr<bool> HasVdbColor(const PlacedVolume& volume,
                                 const VoxelScale& scale,
                                 const Box* box_world,
                                 const Cancellation& cancellation);

}  // namespace steadymap
