#pragma once

#include <vector>

#include "core/association/association.h"
#include "core/association/observation.h"
#include "core/association/sample_grid.h"
#include "core/types/map_config.h"

namespace steadymap {

/// Parts a frame by its labels alone, whatever the map knows: the ground and the classes of the
/// background go to the background, all else falls into connected segments of one class, or of one
/// instance. No segment has an owner yet.
std::vector<Observation> FindSegments(const SampleGrid& samples,
                                      const MapConfig& config,
                                      const Eigen::Vector3d& camera_world,
                                      Association* association);

}  // namespace steadymap
