#pragma once

#include <cstddef>
#include <vector>

#include "core/working/object_edit.h"
#include "core/working/tracked_object.h"

/// Moves voxels between objects, after a merge or for a split.
namespace steadymap {

/// True if the voxels of two objects are on a common lattice: neither is rotated.
bool ShareLattice(const ObjectState& a, const ObjectState& b);

/// Copies all voxels and evidence of `from` to `into`. At equal positions, the voxel with the
/// larger weight is kept. The objects must share their lattice (asserted). `from` is unchanged.
void CopyVoxels(const TrackedObject& from, const VoxelScale& scale, ObjectEdit* into);

/// Adds the voxels of `from`, placed at `T_world_from`, to `into` where `into` has none, with
/// weights of at most `max_weight`. Interpolates distances.
void ResampleVoxels(const TrackedObject& from,
                    const Eigen::Isometry3d& T_world_from,
                    double max_weight,
                    const VoxelScale& scale,
                    ObjectEdit* into);

/// The maximum scores of absent evidence cells.
struct GoneScores {
  int gone = 0;
  /// For cells connected to absent cells, directly or through other such cells.
  int beside_gone = 0;
};

/// Moves the voxels and scores of the absent evidence cells of `object` to `part`, which must have
/// the same frame.
void MoveGoneVoxels(const GoneScores& scores, ObjectEdit* object, ObjectEdit* part);

}  // namespace steadymap
