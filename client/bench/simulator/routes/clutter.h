#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// A storeroom in use, drawn from `seed`: tables and shelves along the walls and one in the middle,
/// and on and between them chairs, boxes, crates, barrels, plants and sacks, many of which touch.
/// All are meshes. The robot looks at it three times; in between some of the loose things go,
/// some come, some are put elsewhere, and some are only pushed by a hand's breadth or two.
Route MakeClutterRoute(std::uint64_t seed);

}  // namespace steadymap
