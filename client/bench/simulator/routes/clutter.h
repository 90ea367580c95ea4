#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// A storeroom generated from `seed`: tables and shelves along the walls and one in the middle, and
/// chairs, boxes, crates, barrels, plants and sacks on and between them, many of which touch. All
/// objects are meshes. The robot records three sequences; in between some of the movable objects
/// are removed, added, relocated, or pushed by 10 to 20 cm.
Route MakeClutterRoute(std::uint64_t seed);

}  // namespace steadymap
