#pragma once

#include "core/policy/ablation.h"
#include "core/policy/object_mapper.h"
#include "core/types/map_config.h"

namespace steadymap {

/// The parameters of the `pocd` policy, with those of the paper for what is off.
ObjectMapperParameters ParametersFor(const MapConfig& config, const Ablation& switches);

}  // namespace steadymap
