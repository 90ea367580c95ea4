#pragma once

#include "core/policy/ablation.h"
#include "core/policy/stage_observer.h"

namespace steadymap {

/// How a mapper differs from the one that a map's configuration asks for: to compare and to
/// measure. A service has none of this.
struct MapperOptions {
  Ablation switches{};              ///< Of the policy `pocd`; the others have none.
  StageObserver* stages = nullptr;  ///< Outlives the mapper; null: nobody watches.
};

}  // namespace steadymap
