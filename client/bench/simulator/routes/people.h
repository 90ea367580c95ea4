#pragma once

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// The TorWIC hall with persons and a forklift passing through. They cross the robot's past and
/// future field of view and must leave no trace in a map.
Route MakePeopleRoute();

}  // namespace steadymap
