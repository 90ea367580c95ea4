#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/geometry.h"

namespace steadymap {

/// A tree of bounding boxes that finds the boxes at a point or along a ray without a test of each
/// box. Immutable after construction. Thread-safe.
class BoxTree {
 public:
  /// Builds the tree. A box is identified by its index in `boxes`; none may be empty. Cost: about 1
  /// us per box.
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls `visit` for every box that contains the point, borders included, in a fixed but
  /// unspecified order. A point with a non-finite coordinate is in no box.
  void VisitAt(const Eigen::Vector3d& point,
               const std::function<void(std::size_t box)>& visit) const;

  /// The intersection of a ray with a box.
  struct Crossing {
    double entry_m = 0.0;  ///< Distance of the entry point, metres; 0 if the ray starts inside.
    std::size_t box = 0;
    double exit_m = 0.0;  ///< Distance of the exit point, at most `max_range_m`, metres.

    friend auto operator<=>(const Crossing&, const Crossing&) = default;
  };

  /// Returns the boxes that a ray intersects within `max_range_m`, by increasing entry, then by
  /// index. `unit_direction` must have length one.
  std::vector<Crossing> FindAlong(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& unit_direction,
                                  double max_range_m) const;

 private:
  /// A leaf holds the boxes `order_[first]` to `order_[first + count - 1]`. An inner node has
  /// `count` 0; its first child follows it directly, its second child is at `second_child`.
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
