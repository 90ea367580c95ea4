#pragma once

#include <optional>

#include <Eigen/Core>

#include "core/geometry/geometry.h"

namespace steadymap {

/// An interval of a ray, metres from its origin.
struct RaySpan {
  double enter_m = 0.0;
  double leave_m = 0.0;  ///< >= `enter_m`.
};

/// Returns the interval of a ray, of length `max_range_m`, within a box, borders included; none if
/// the ray misses the box. `direction` must have length one.
std::optional<RaySpan> ClipRay(const Box& box,
                               const Eigen::Vector3d& origin,
                               const Eigen::Vector3d& direction,
                               double max_range_m);

}  // namespace steadymap
