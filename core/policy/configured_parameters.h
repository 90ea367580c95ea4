#pragma once

#include "core/policy/evidence_mapper.h"
#include "core/policy/paper_mapper.h"
#include "core/policy/submap_change.h"
#include "core/policy/tracking.h"
#include "core/policy/voxel_change.h"
#include "core/types/map_config.h"

/// The parameters of the policies with the values that a map's configuration sets
/// (`policy_parameters.h`). The configuration must be valid and of that policy (asserted).
namespace steadymap {

VoxelChangeParameters VoxelChangeParametersOf(const MapConfig& config);
SubmapChangeParameters SubmapChangeParametersOf(const MapConfig& config);
TrackingParameters TrackingParametersOf(const MapConfig& config);
PaperParameters PaperParametersOf(const MapConfig& config);
EvidenceMapperParameters EvidenceParametersOf(const MapConfig& config);

}  // namespace steadymap
