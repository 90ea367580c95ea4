#include "core/geometry/box_tree.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/geometry/ray_box.h"

namespace steadymap {
namespace {

/// With at most this many boxes, a test of each box is faster than a further level of the tree.
constexpr std::size_t kMaxLeafBoxes = 4;

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) : boxes_(boxes), order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  nodes_.reserve(2 * boxes.size() / kMaxLeafBoxes + 1);
  if (!boxes.empty()) Build(0, boxes.size());
}

/// Appends the tree of some boxes. Splits them at the median along the axis on which their centres
/// have the largest spread.
void BoxTree::Build(std::size_t first, std::size_t count) {
  const std::size_t index = nodes_.size();
  Node& node = nodes_.emplace_back();
  Box centers;
  for (std::size_t i = first; i < first + count; ++i) {
    node.bounds.extend(boxes_[order_[i]]);
    centers.extend(Eigen::Vector3d(boxes_[order_[i]].center()));
  }
  if (count <= kMaxLeafBoxes) {
    node.first = first;
    node.count = count;
    return;
  }
  int axis = 0;
  centers.sizes().maxCoeff(&axis);
  const std::size_t half = count / 2;
  const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(first);
  std::nth_element(begin,
                   begin + static_cast<std::ptrdiff_t>(half),
                   begin + static_cast<std::ptrdiff_t>(count),
                   [&](std::size_t a, std::size_t b) {
                     return std::pair(boxes_[a].center()[axis], a) <
                            std::pair(boxes_[b].center()[axis], b);
                   });
  Build(first, half);
  nodes_[index].second_child = nodes_.size();
  Build(first + half, count - half);
}

void BoxTree::VisitAt(const Eigen::Vector3d& point,
                      const std::function<void(std::size_t box)>& visit) const {
  std::vector<std::size_t> open;
  if (!nodes_.empty()) open.push_back(0);
  while (!open.empty()) {
    const std::size_t index = open.back();
    const Node& node = nodes_[index];
    open.pop_back();
    if (!node.bounds.contains(point)) continue;
    if (node.count == 0) open.insert(open.end(), {node.second_child, index + 1});
    for (std::size_t i = node.first; i < node.first + node.count; ++i) {
      if (boxes_[order_[i]].contains(point)) visit(order_[i]);
    }
  }
}

std::vector<BoxTree::Crossing> BoxTree::FindAlong(const Eigen::Vector3d& origin,
                                                  const Eigen::Vector3d& unit_direction,
                                                  double max_range_m) const {
  std::vector<Crossing> crossings;
  std::vector<std::size_t> open;
  if (!nodes_.empty()) open.push_back(0);
  while (!open.empty()) {
    const std::size_t index = open.back();
    const Node& node = nodes_[index];
    open.pop_back();
    if (!ClipRay(node.bounds, origin, unit_direction, max_range_m)) continue;
    if (node.count == 0) open.insert(open.end(), {node.second_child, index + 1});
    for (std::size_t i = node.first; i < node.first + node.count; ++i) {
      const std::optional<RaySpan> span =
          ClipRay(boxes_[order_[i]], origin, unit_direction, max_range_m);
      if (span) crossings.push_back({span->enter_m, order_[i], span->leave_m});
    }
  }
  std::sort(crossings.begin(), crossings.end());
  return crossings;
}

}  // namespace steadymap
