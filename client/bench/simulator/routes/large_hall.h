#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/route.h"

namespace steadymap {

/// The size of a generated warehouse.
struct LargeHallOptions {
  int aisles = 12;               ///< In [1, 60], 3 m wide, with a rack on each side.
  double aisle_length_m = 40.0;  ///< In [5, 100].
  double filled_share = 0.85;    ///< Of the places on the shelves that hold goods, in [0, 1].
  std::uint64_t seed = 1;        ///< Of which places are filled, and with what.
};

/// A warehouse of racks full of boxes, and a drive through all its aisles; for scale. The defaults
/// give some 3 000 objects and 3 900 frames.
/// Errors: `InvalidArgument` for an option out of range.
absl::StatusOr<Route> MakeLargeHallRoute(const LargeHallOptions& options);

}  // namespace steadymap
