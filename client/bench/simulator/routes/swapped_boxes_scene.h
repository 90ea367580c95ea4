#pragma once

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// Two boxes alike in front of a wall: at first both; then they have changed places, which no
/// camera can see; then one of them is gone.
Route MakeSwappedBoxesRoute();

}  // namespace steadymap
