#pragma once

#include "core/policy/ablation.h"
#include "core/policy/stage_observer.h"

namespace steadymap {

/// Differences between a mapper and the configuration of its map, for comparisons and measurements.
/// A service uses the defaults.
struct MapperOptions {
  Ablation switches{};              ///< Of the policy `pocd`; no effect on other policies.
  StageObserver* stages = nullptr;  ///< Outlives the mapper. Null: no observer.
};

}  // namespace steadymap
