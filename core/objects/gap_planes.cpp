#include "core/objects/gap_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/objects/point_grid.h"

namespace steadymap {
namespace {

// More are not kept: a room of clutter has a few thousand, frames made to do harm have any number.
constexpr std::size_t kMaxGaps = 1 << 15;

// Surface that goes on from one side of a gap to the other faces along it; the sides of things
// beside the gap face across it.
constexpr double kMaxCrossingCosine = M_SQRT1_2;

using Cell = std::array<std::int32_t, 3>;

Cell CellOf(const Eigen::Vector3d& point_world, double voxel_size_m) {
  const Eigen::Vector3i index = (point_world / voxel_size_m).array().round().cast<int>();
  return {index.x(), index.y(), index.z()};
}

/// Adds a direction or its opposite.
void AddDirection(const Eigen::Vector2d& direction, Eigen::Vector2d* sum) {
  *sum += sum->dot(direction) < 0.0 ? Eigen::Vector2d(-direction) : direction;
}

SeenGap SeenBy(const GapInView& gap, const Cell& cell) {
  SeenGap seen;
  seen.cell = cell;
  seen.frames = 1;
  seen.weight = 1.0 / (gap.max_angle_rad * gap.max_angle_rad);
  seen.width_m = gap.width_m;
  seen.middle_world = gap.middle_world;
  seen.view_sum_world = seen.weight * gap.view_world;
  return seen;
}

/// Adds what other frames have seen at the same place.
void AddSeen(const SeenGap& added, SeenGap* gap) {
  gap->frames += added.frames;
  gap->weight += added.weight;
  const double share = added.weight / gap->weight;
  gap->width_m += share * (added.width_m - gap->width_m);
  gap->middle_world += share * (added.middle_world - gap->middle_world);
  AddDirection(added.view_sum_world, &gap->view_sum_world);
}

/// True if two places may be of one gap.
bool Continues(const SeenGap& a, const SeenGap& b, double min_cosine, double voxel_size_m) {
  const Eigen::Vector2d view = a.view_sum_world.normalized();
  const Eigen::Vector3d way = b.middle_world - a.middle_world;
  const double across_m = view.x() * way.y() - view.y() * way.x();
  return std::abs(across_m) <= voxel_size_m &&
         std::abs(view.dot(b.view_sum_world.normalized())) >= min_cosine;
}

/// Divides places into gaps.
std::vector<std::vector<SeenGap>> FindClusters(const GapPlaneParameters& parameters,
                                               const std::vector<SeenGap>& places,
                                               double voxel_size_m) {
  std::vector<OrientedPoint> points;
  points.reserve(places.size());
  for (const SeenGap& place : places) points.push_back({place.middle_world});
  const PointGrid grid(points, parameters.reach_m);
  std::vector<char> is_visited(places.size(), 0);
  std::vector<std::vector<SeenGap>> clusters;
  for (std::size_t seed = 0; seed < places.size(); ++seed) {
    if (is_visited[seed] != 0) continue;
    is_visited[seed] = 1;
    std::vector<std::size_t> region = {seed};
    for (std::size_t next = 0; next < region.size(); ++next) {
      const std::size_t from = region[next];
      grid.ForEachNeighbour(from, [&](std::size_t other) {
        if (is_visited[other] != 0 ||
            !Continues(places[from], places[other], parameters.min_cosine, voxel_size_m))
          return;
        is_visited[other] = 1;
        region.push_back(other);
      });
    }
    std::vector<SeenGap>& cluster = clusters.emplace_back();
    for (const std::size_t index : region) cluster.push_back(places[index]);
  }
  return clusters;
}

GapPlane PlaneOf(const std::vector<SeenGap>& gaps) {
  GapPlane plane;
  SeenGap all;
  for (const SeenGap& gap : gaps) {
    AddSeen(gap, &all);
    plane.seen_world.push_back(gap.middle_world);
  }
  plane.center_world = all.middle_world;
  plane.normal_world =
      Eigen::Vector3d(all.view_sum_world.y(), -all.view_sum_world.x(), 0.0).normalized();
  plane.width_m = all.width_m;
  return plane;
}

/// The range of a number.
class Range {
 public:
  void Extend(double value) {
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }

  double length() const { return std::max(0.0, high_ - low_); }

 private:
  double low_ = std::numeric_limits<double>::max();
  double high_ = std::numeric_limits<double>::lowest();
};

/// The squares of a voxel in the plane of a gap.
class PlacesInGap {
 public:
  using Place = std::pair<int, int>;

  PlacesInGap(const GapPlane& gap, double voxel_size_m)
      : gap_(gap),
        along_world_(gap.normal_world.cross(Eigen::Vector3d::UnitZ())),
        voxel_size_m_(voxel_size_m) {
    for (const Eigen::Vector3d& point : gap.seen_world) seen_.insert(At(point));
  }

  Place At(const Eigen::Vector3d& point_world) const {
    const Eigen::Vector3d way = (point_world - gap_.center_world) / voxel_size_m_;
    return {static_cast<int>(std::floor(way.dot(along_world_))),
            static_cast<int>(std::floor(way.z()))};
  }

  /// True if a point at a distance from the plane may be at an edge of the gap.
  bool IsNear(double distance_m) const {
    return std::abs(distance_m) <= 0.5 * gap_.width_m + voxel_size_m_;
  }

  /// Returns the places looked through beside a place.
  std::vector<Place> EdgesAt(const Place& place) const {
    std::vector<Place> edges;
    for (int column = place.first - 1; column <= place.first + 1; ++column) {
      for (int row = place.second - 1; row <= place.second + 1; ++row) {
        if (seen_.contains({column, row})) edges.emplace_back(column, row);
      }
    }
    return edges;
  }

 private:
  const GapPlane& gap_;
  Eigen::Vector3d along_world_;
  double voxel_size_m_;
  std::set<Place> seen_;
};

}  // namespace

void AddGaps(std::span<const GapInView> gaps, double voxel_size_m, std::vector<SeenGap>* into) {
  // The lines of one frame that look through a place are one look; the best of them counts.
  std::map<Cell, const GapInView*> best_of;
  for (const GapInView& gap : gaps) {
    const GapInView*& best = best_of[CellOf(gap.middle_world, voxel_size_m)];
    if (best == nullptr || gap.max_angle_rad < best->max_angle_rad) best = &gap;
  }
  std::vector<SeenGap> added;
  added.reserve(best_of.size());
  for (const auto& [cell, gap] : best_of) added.push_back(SeenBy(*gap, cell));
  MergeGaps(added, into);
}

void MergeGaps(std::span<const SeenGap> added, std::vector<SeenGap>* into) {
  const auto is_before = [](const SeenGap& a, const SeenGap& b) { return a.cell < b.cell; };
  const auto known_count = std::ssize(*into);
  for (const SeenGap& gap : added) {
    const auto known_end = into->begin() + known_count;  // Valid until the next addition.
    const auto place = std::lower_bound(into->begin(), known_end, gap, is_before);
    if (place != known_end && place->cell == gap.cell) {
      AddSeen(gap, &*place);
    } else if (into->size() < kMaxGaps) {
      into->push_back(gap);
    }
  }
  std::inplace_merge(into->begin(), into->begin() + known_count, into->end(), is_before);
}

std::vector<GapPlane> FindGapPlanes(const GapPlaneParameters& parameters,
                                    std::span<const SeenGap> gaps,
                                    double voxel_size_m) {
  std::vector<SeenGap> places;
  std::copy_if(gaps.begin(), gaps.end(), std::back_inserter(places), [&](const SeenGap& gap) {
    return gap.frames >= parameters.min_frames;
  });
  std::vector<GapPlane> planes;
  for (const std::vector<SeenGap>& cluster : FindClusters(parameters, places, voxel_size_m)) {
    planes.push_back(PlaneOf(cluster));
  }
  std::stable_sort(planes.begin(), planes.end(), [](const GapPlane& a, const GapPlane& b) {
    return a.seen_world.size() > b.seen_world.size();
  });
  return planes;
}

bool Divides(const GapPlane& gap, std::span<const OrientedPoint> points, double voxel_size_m) {
  const PlacesInGap places(gap, voxel_size_m);
  std::set<PlacesInGap::Place> seen;
  std::set<PlacesInGap::Place> connected;
  bool is_before = false;
  bool is_behind = false;
  Range height;
  for (const OrientedPoint& point : points) {
    const double distance_m = gap.DistanceOf(point.position_world);
    if (!places.IsNear(distance_m)) continue;
    height.Extend(point.position_world.z());
    const PlacesInGap::Place place = places.At(point.position_world);
    const std::vector<PlacesInGap::Place> edges = places.EdgesAt(place);
    if (!edges.empty()) {
      (distance_m < 0.0 ? is_before : is_behind) = true;
      seen.insert(edges.begin(), edges.end());
    } else if (std::abs(distance_m) <= voxel_size_m &&
               std::abs(gap.normal_world.dot(point.normal_world)) < kMaxCrossingCosine) {
      connected.insert(place);
    }
  }
  if (!is_before || !is_behind || connected.size() >= seen.size()) return false;
  Range seen_height;
  for (const Eigen::Vector3d& point : gap.seen_world) {
    if (seen.contains(places.At(point))) seen_height.Extend(point.z());
  }
  // Things beside each other are apart from top to bottom, an opening is not.
  return 2.0 * seen_height.length() >= height.length();
}

bool IsBeside(const GapPlane& gap, std::span<const OrientedPoint> points, double voxel_size_m) {
  const PlacesInGap places(gap, voxel_size_m);
  return std::any_of(points.begin(), points.end(), [&](const OrientedPoint& point) {
    return places.IsNear(gap.DistanceOf(point.position_world)) &&
           !places.EdgesAt(places.At(point.position_world)).empty();
  });
}

}  // namespace steadymap
