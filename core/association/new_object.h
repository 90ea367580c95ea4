#pragma once

#include "core/association/observation.h"
#include "core/association/sample_grid.h"
#include "core/working/tracked_object.h"
#include "core/working/working_map.h"

namespace steadymap {

/// A new object of the observation's class around it, without voxels yet.
TrackedObject& AddObjectOf(const Observation& observation,
                           const SampleGrid& samples,
                           WorkingMap* map);

}  // namespace steadymap
