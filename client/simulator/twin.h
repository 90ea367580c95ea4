#pragma once

#include "client/simulator/route.h"

namespace steadymap {

/// Two boxes alike in front of a wall: at first both; then they have changed places, which no
/// camera can see; then one of them is gone.
Route MakeTwinRoute();

}  // namespace steadymap
