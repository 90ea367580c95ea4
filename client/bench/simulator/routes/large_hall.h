#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// Size of a generated warehouse.
struct LargeHallOptions {
  int aisles = 12;               ///< In [1, 60], 3 m wide, with a rack on each side.
  double aisle_length_m = 40.0;  ///< In [5, 100].
  double filled_share = 0.85;    ///< Share of shelf places with goods, in [0, 1].
  std::uint64_t seed = 1;        ///< Selects the filled places and their goods.
};

/// A warehouse of racks full of boxes and a drive through all its aisles, for tests of scale. The
/// defaults give about 3 000 objects and 3 900 frames. Errors: `InvalidArgument` for an option out
/// of range.
absl::StatusOr<Route> MakeLargeHallRoute(const LargeHallOptions& options);

}  // namespace steadymap
