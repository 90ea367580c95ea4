#pragma once

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// The TorWIC hall with persons and a forklift passing through. They are where the robot has been
/// and will be, and must leave nothing behind in a map.
Route MakePeopleRoute();

}  // namespace steadymap
