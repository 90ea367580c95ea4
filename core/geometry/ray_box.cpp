#include "core/geometry/ray_box.h"

#include <algorithm>

namespace steadymap {

std::optional<RaySpan> ClipRay(const Box& box,
                               const Eigen::Vector3d& origin,
                               const Eigen::Vector3d& direction,
                               double max_range_m) {
  RaySpan span{0.0, max_range_m};
  for (int axis = 0; axis < 3; ++axis) {
    // Division by zero would give NaN for a ray in the plane of a side.
    if (direction[axis] == 0.0) {
      if (origin[axis] < box.min()[axis] || origin[axis] > box.max()[axis]) return std::nullopt;
      continue;
    }
    const double at_min_m = (box.min()[axis] - origin[axis]) / direction[axis];
    const double at_max_m = (box.max()[axis] - origin[axis]) / direction[axis];
    span.enter_m = std::max(span.enter_m, std::min(at_min_m, at_max_m));
    span.leave_m = std::min(span.leave_m, std::max(at_min_m, at_max_m));
  }
  if (!(span.enter_m <= span.leave_m)) return std::nullopt;
  return span;
}

}  // namespace steadymap
