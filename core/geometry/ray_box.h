#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/geometry.h"

namespace steadymap {

/// A part of a ray, metres from its origin.
struct RaySpan {
  double enter_m = 0.0;
  double leave_m = 0.0;  ///< Not below `enter_m`.
};

/// The part of a ray's first `max_range_m` within a box, borders included; none where it misses the
/// box. `direction` has length one.
std::optional<RaySpan> ClipRay(const Box& box,
                               const Eigen::Vector3d& origin,
                               const Eigen::Vector3d& direction,
                               double max_range_m);

}  // namespace steadymap
