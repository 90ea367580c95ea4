#pragma once

#include <cstddef>
#include <vector>

#include "core/working/tracked_object.h"

/// Moves voxels between objects that turn out to be one, or one that turns out to be two.
namespace steadymap {

/// Leaves that changed, each in its own object's frame.
struct MovedLeaves {
  std::vector<LeafOrigin> from;
  std::vector<LeafOrigin> into;
};

/// Whether the voxels of two objects lie on one lattice: neither was turned.
bool ShareLattice(const ObjectState& a, const ObjectState& b);

/// Copies all voxels and evidence of `from` into `into`; of two voxels in one place the one that
/// was seen better stays. The objects must share their lattice (asserted). `from` keeps its voxels.
MovedLeaves CopyVoxels(const TrackedObject& from, const VoxelScale& scale, TrackedObject* into);

/// Gives `into` what `from` knows and it does not, as if `from` stood at `T_world_from`, with
/// weights of at most `max_weight`; the leaves that changed, in the frame of `into`. Distances are
/// interpolated where the lattices differ.
std::vector<LeafOrigin> ResampleVoxels(const TrackedObject& from,
                                       const Eigen::Isometry3d& T_world_from,
                                       double max_weight,
                                       const VoxelScale& scale,
                                       TrackedObject* into);

/// Cells of an object's surface that frames have missed.
struct DoubtedCells {
  std::size_t gone = 0;     ///< With scores of at most `max_score`.
  std::size_t doubted = 0;  ///< With negative scores, those included.
  std::size_t all = 0;      ///< Missed or not.
};

DoubtedCells CountDoubtedCells(const TrackedObject& object, int max_score);

/// Cells of an object's surface that were found oftener than missed, in leaves where something was
/// found at `since` or later.
std::size_t CountFoundCells(const TrackedObject& object, Timestamp since);

/// Cells of the largest group of an object's surface that are connected, by their corners at least.
std::size_t CountConnectedCells(const TrackedObject& object);

/// Up to which scores cells are gone.
struct GoneScores {
  int gone = 0;
  /// Beside cells that are gone, and beside those that are gone for that reason.
  int beside_gone = 0;
};

/// Moves the evidence cells that are gone to `part`, which must have the same frame as `object`:
/// their voxels and their scores. The leaves that changed.
std::vector<LeafOrigin> MoveGoneVoxels(const GoneScores& scores,
                                       TrackedObject* object,
                                       TrackedObject* part);

}  // namespace steadymap
