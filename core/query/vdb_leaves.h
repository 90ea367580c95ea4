#pragma once

#include <vector>

#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/map/placed_volume.h"
#include "core/types/cancellation.h"
#include "core/volume/voxel_leaf.h"

/// Private to the vdb files: the selection of the voxels of a file.
namespace steadymap {

/// A leaf of a grid with the mask of the selected voxels, at least one.
struct MaskedLeaf {
  LeafOrigin origin;
  LeafMask mask{};
};

/// The leaves of the grids of a volume. Each list is in the order of a stock OpenVDB tree (nodes of
/// 4096, 128 and 8 voxels per side).
struct VdbLeaves {
  std::vector<MaskedLeaf> observed;  ///< For distance and weight.
  std::vector<MaskedLeaf> colored;   ///< The observed voxels with a colour.
};

/// Selects the observed voxels of a volume, or if `box_world` is not null, those with their centre
/// in the box. Cost: 0.1 us per leaf; with a box 5 us per leaf that touches it. Errors:
/// `Cancelled`.
absl::StatusOr<VdbLeaves> ChooseVdbLeaves(const PlacedVolume& volume,
                                          const VoxelScale& scale,
                                          const Box* box_world,
                                          const Cancellation& cancellation);

/// True if `ChooseVdbLeaves` would select a coloured voxel. Stops at the first. Errors:
/// `Cancelled`.
absl::StatusOr<bool> HasVdbColor(const PlacedVolume& volume,
                                 const VoxelScale& scale,
                                 const Box* box_world,
                                 const Cancellation& cancellation);

}  // namespace steadymap
