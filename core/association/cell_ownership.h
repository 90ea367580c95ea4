#pragma once

#include "core/association/association.h"
#include "core/association/sample_grid.h"
#include "core/integration/semantic_cloud.h"

namespace steadymap {

/// Gives every cell of a frame to the owner of a sample in whose plane it lies, or takes its weight
/// if there is none: what nobody owns is not fused.
void GiveCellsToOwners(const SampleGrid& samples,
                       const Association& association,
                       SemanticCloud* cloud);

/// As `GiveCellsToOwners`, but to the owner of the sample whose plane is nearest.
void GiveCellsToNearestPlanes(const SampleGrid& samples,
                              const Association& association,
                              SemanticCloud* cloud);

}  // namespace steadymap
