#pragma once

#include <vector>

#include "core/association.h"
#include "core/map_config.h"
#include "core/observation.h"
#include "core/sample_grid.h"

namespace steadymap {

/// Parts a frame by its labels alone, whatever the map knows: the ground and the classes of the
/// background go to the background, all else falls into connected segments of one class, or of one
/// instance. No segment has an owner yet.
std::vector<Observation> FindSegments(const SampleGrid& samples,
                                      const MapConfig& config,
                                      double camera_height_m,
                                      Association* association);

}  // namespace steadymap
