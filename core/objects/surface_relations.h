#pragma once

#include <cstddef>
#include <vector>

#include "core/volume/free_space.h"
#include "core/working/tracked_object.h"

/// How the surfaces of two objects tell whether both can be there.
namespace steadymap {

/// Returns the number of evidence cells of `object` whose surface was found (`CountLooks`) where
/// the surface of one of `others` is, so that the looks do not tell which of both they found. A
/// look finds surface up to `reach_m` beyond its edge, since samples are apart.
std::size_t CountExplainedCells(const TrackedObject& object,
                                const std::vector<const TrackedObject*>& others,
                                double reach_m,
                                const VoxelScale& scale);

/// Returns the share of the surface of `object` that has `other` in front of it, along its normals.
double HiddenShare(const TrackedObject& object,
                   const TrackedObject& other,
                   const VoxelScale& scale);

/// Returns the share of the surface of `object` that has free space just behind it: something was
/// seen through it.
double FreeShareOf(const TrackedObject& object, const FreeSpaceSince& free_space);

/// Sets the scores of the cells in `evidence` of which that is true for most of the surface to
/// gone.
void DoubtFreeCells(const TrackedObject& object,
                    const FreeSpaceSince& free_space,
                    ObjectEvidence* evidence);

}  // namespace steadymap
