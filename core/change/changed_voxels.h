#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

/// Where two volumes of the same frame disagree.
namespace steadymap {

/// When voxels differ, and when that is a change.
struct ChangedVoxelParameters {
  /// Voxels are compared if both weigh at least this; one look at 1 m, face on, weighs 1.
  double min_weight = 0.3;
  /// They differ if their distances are further apart than this share of the truncation, in (0, 1].
  double min_difference = 0.5;
  /// Beyond this share of the truncation before a surface a voxel counts as free, in (0, 1].
  double free_from = 0.95;
  /// Voxels that a change must have at least, connected by faces, edges or corners.
  std::size_t min_voxels = 30;
};

/// The voxels of one change within one leaf.
struct ChangedLeaf {
  LeafOrigin origin;
  LeafMask voxels{};
};

/// Connected voxels in which two volumes differ.
struct VoxelChange {
  std::vector<ChangedLeaf> leaves;  ///< By rising origin.
  std::size_t voxels = 0;
  std::size_t freed = 0;  ///< Voxels at a surface before, free now.
  std::size_t taken = 0;  ///< Voxels before the surface or free before, at a surface now.
  Eigen::Vector3d mean_voxel = Eigen::Vector3d::Zero();  ///< Index in the volume.
};

/// Whether the distance of a voxel says that it is free.
bool IsFree(Voxel voxel, const VoxelScale& scale, const ChangedVoxelParameters& parameters);

/// Whether a voxel of two leaves, observed in both, can be compared.
bool IsComparable(const LeafView& before,
                  const LeafView& after,
                  std::size_t offset,
                  const ChangedVoxelParameters& parameters);

/// Whether a comparable voxel differs.
bool IsDifferent(const LeafView& before,
                 const LeafView& after,
                 std::size_t offset,
                 const VoxelScale& scale,
                 const ChangedVoxelParameters& parameters);

/// The changes from `before` to `after` within the leaves `origins` (sorted, each once): connected
/// across them, of enough voxels, and somewhere two voxels thick along all axes, together with what
/// `after` knows as open space. In the order of their first leaf. Cost: about 1 us a leaf, 0.3 us a
/// voxel that differs.
std::vector<VoxelChange> FindChanges(const VoxelReader& before,
                                     const VoxelReader& after,
                                     const std::vector<LeafOrigin>& origins,
                                     const VoxelScale& scale,
                                     const ChangedVoxelParameters& parameters);

}  // namespace steadymap
