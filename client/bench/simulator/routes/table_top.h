#pragma once

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// A table with static blocks and two toy cars that drive about, seen by a camera that circles it;
/// frames carry instance labels. The cars are `misc dynamic`, the blocks `misc static`.
Route MakeTableTopRoute();

}  // namespace steadymap
