#pragma once

#include "core/engine_switches.h"
#include "core/map_config.h"
#include "core/object_mapper.h"

namespace steadymap {

/// The parameters of the `pocd` policy, with those of the paper for what is off.
ObjectMapperParameters ParametersFor(const MapConfig& config, const EngineSwitches& switches);

}  // namespace steadymap
