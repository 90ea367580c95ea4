#pragma once

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// A table with static blocks and two moving toy cars, observed by a camera that circles it; frames
/// contain instance labels. The cars are `misc dynamic`, the blocks `misc static`.
Route MakeTableTopRoute();

}  // namespace steadymap
