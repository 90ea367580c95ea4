#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/geometry.h"

namespace steadymap {

/// Finds those of many boxes that hold a point or that a ray crosses, without asking each: a tree
/// of boxes around boxes. Never changes once it is built; any number of threads may ask.
class BoxTree {
 public:
  /// Boxes are known by their place in the list; none may be empty. Cost: about 1 us a box.
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls `visit` for every box that holds the point, borders included, in an order of the tree's
  /// own. A point that is not finite lies in none.
  void VisitAt(const Eigen::Vector3d& point,
               const std::function<void(std::size_t box)>& visit) const;

  /// A box on a ray's way.
  struct Crossing {
    double entry_m = 0.0;  ///< Where the ray enters it; 0 if it starts inside.
    std::size_t box = 0;
    double exit_m = 0.0;  ///< Where it leaves the box or ends.

    friend auto operator<=>(const Crossing&, const Crossing&) = default;
  };

  /// The boxes that a ray meets within `max_range_m`, by rising entry, then by place in the list.
  /// `unit_direction` must have length one.
  std::vector<Crossing> FindAlong(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& unit_direction,
                                  double max_range_m) const;

 private:
  /// A leaf holds the boxes `order_[first]` to `order_[first + count - 1]`; a node without boxes
  /// of its own has its first child right behind it and its second at `second_child`.
  struct Node {
    Box bounds;
    std::size_t first = 0;
    std::size_t count = 0;
    std::size_t second_child = 0;
  };

  void Build(std::size_t first, std::size_t count);

  std::vector<Box> boxes_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace steadymap
