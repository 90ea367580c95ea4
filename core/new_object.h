#pragma once

#include "core/observation.h"
#include "core/sample_grid.h"
#include "core/tracked_object.h"
#include "core/working_map.h"

namespace steadymap {

/// A new object of the observation's class around it, without voxels yet.
TrackedObject& AddObjectOf(const Observation& observation,
                           const SampleGrid& samples,
                           WorkingMap* map);

}  // namespace steadymap
