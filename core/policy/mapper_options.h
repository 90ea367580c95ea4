#pragma once

#include "core/policy/ablation.h"
#include "core/policy/stage_observer.h"

namespace steadymap {

/// Differences between a mapper and the configuration of its map, for comparisons and measurements.
/// A service uses the defaults.
struct MapperOptions {
  Ablation switches{};  ///< Of the policy `pocd`; no effect on other policies.
  /// True: `pocd` decides what objects are at the end of each session, instead of frame by frame.
  bool decides_by_session = false;
  StageObserver* stages = nullptr;  ///< Outlives the mapper. Null: no observer.
};

}  // namespace steadymap
