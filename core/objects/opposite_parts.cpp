#include "core/objects/opposite_parts.h"

#include <algorithm>
#include <map>
#include <optional>

#include "core/objects/point_grid.h"

namespace steadymap {
namespace {

// Steps along a line, and the distance from it within which a point is on it, spacings.
constexpr double kStepSpacings = 0.5;
constexpr double kOnLineSpacings = 0.87;

// The surface around the start of a line is not behind it, spacings.
constexpr double kFirstSpacings = 1.5;

/// The search for the opposite sides of points.
class OppositeSearch {
 public:
  OppositeSearch(std::span<const OrientedPoint> points,
                 double spacing_m,
                 const OppositeSideParameters& parameters)
      : points_(points),
        grid_(points, kOnLineSpacings * spacing_m),
        spacing_m_(spacing_m),
        parameters_(parameters) {}

  /// Returns the first point inwards from a point, if its surface faces the other way.
  std::optional<std::size_t> OppositeOf(const OrientedPoint& start) const {
    for (int step = 0;; ++step) {
      const double depth_m = (kFirstSpacings + kStepSpacings * step) * spacing_m_;
      if (depth_m > parameters_.max_thickness_m) return std::nullopt;
      const Eigen::Vector3d place = start.position_world - depth_m * start.normal_world;
      std::optional<std::size_t> opposite;
      bool is_outside = false;
      grid_.ForEachNear(place, [&](std::size_t index) {
        const double cosine = points_[index].normal_world.dot(start.normal_world);
        if (cosine >= parameters_.min_cosine) is_outside = true;
        if (cosine <= -parameters_.min_cosine) opposite = index;
      });
      if (opposite) return opposite;
      if (is_outside) return std::nullopt;
    }
  }

 private:
  std::span<const OrientedPoint> points_;
  PointGrid grid_;
  double spacing_m_;
  const OppositeSideParameters& parameters_;
};

}  // namespace

std::vector<std::size_t> FindOppositeParts(std::span<const OrientedPoint> points,
                                           std::span<const std::vector<std::size_t>> parts,
                                           double spacing_m,
                                           const OppositeSideParameters& parameters) {
  constexpr std::size_t kNoPart = ~std::size_t{0};
  std::vector<std::size_t> part_of(points.size(), kNoPart);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (const std::size_t point : parts[i]) part_of[point] = i;
  }
  const OppositeSearch search(points, spacing_m, parameters);
  std::vector<std::size_t> opposite_of;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::map<std::size_t, std::size_t> counts;
    for (const std::size_t point : parts[i]) {
      const std::optional<std::size_t> opposite = search.OppositeOf(points[point]);
      if (opposite && part_of[*opposite] != kNoPart) ++counts[part_of[*opposite]];
    }
    const double least = parameters.min_share * static_cast<double>(parts[i].size());
    opposite_of.push_back(i);
    std::size_t most = 0;
    for (const auto& [part, count] : counts) {
      if (part == i || count <= most || static_cast<double>(count) < least) continue;
      most = count;
      opposite_of.back() = part;
    }
  }
  return opposite_of;
}

}  // namespace steadymap
