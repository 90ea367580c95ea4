#pragma once

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// Two equal boxes in front of a wall. First sequence: both; second: they have swapped places,
/// which is unobservable; third: one of them is removed.
Route MakeSwappedBoxesRoute();

}  // namespace steadymap
