#pragma once

#include "client/simulator/route.h"

namespace steadymap {

/// A table with static blocks and two toy cars that drive about, seen by a camera that circles it;
/// frames carry instance labels. The cars are `misc dynamic`, the blocks `misc static`.
Route MakeTableTopRoute();

/// Two boxes alike in front of a wall: at first both; then they have changed places, which no
/// camera can see; then one of them is gone.
Route MakeTwinRoute();

/// The TorWIC hall with persons and a forklift passing through. They are where the robot has been
/// and will be, and must leave nothing behind in a map.
Route MakePeopleRoute();

}  // namespace steadymap
