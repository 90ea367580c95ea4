#include "core/objects/surface_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <unordered_map>

#include <Eigen/Eigenvalues>

#include "core/objects/point_grid.h"

namespace steadymap {
namespace {

// A plane is estimated again when it has grown by this factor.
constexpr double kPlaneGrowth = 1.5;

// Smallest part of a plane that is grown, points: less has no reliable normal.
constexpr std::size_t kMinSeedPoints = 8;

/// The plane through a growing set of points.
class GrowingPlane {
 public:
  explicit GrowingPlane(const OrientedPoint& seed) { Add(seed); }

  void Add(const OrientedPoint& point) {
    position_sum_ += point.position_world;
    normal_sum_ += point.normal_world;
    ++count_;
    if (static_cast<double>(count_) > kPlaneGrowth * static_cast<double>(estimated_count_)) {
      Estimate();
    }
  }

  double DistanceOf(const OrientedPoint& point) const {
    return std::abs(normal_.dot(point.position_world - center_));
  }

  double CosineOf(const OrientedPoint& point) const { return normal_.dot(point.normal_world); }

 private:
  void Estimate() {
    center_ = position_sum_ / static_cast<double>(count_);
    normal_ = normal_sum_.normalized();
    estimated_count_ = count_;
  }

  Eigen::Vector3d position_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitZ();
  std::size_t count_ = 0;
  std::size_t estimated_count_ = 0;
};

/// Returns the points of the plane around a seed, and marks them in `is_visited`.
std::vector<std::size_t> GrowPlane(std::span<const OrientedPoint> points,
                                   const PointGrid& grid,
                                   std::size_t seed,
                                   const PlaneParameters& parameters,
                                   std::vector<char>* is_visited) {
  GrowingPlane plane(points[seed]);
  std::vector<std::size_t> region = {seed};
  (*is_visited)[seed] = 1;
  for (std::size_t next = 0; next < region.size(); ++next) {
    grid.ForEachNeighbour(region[next], [&](std::size_t other) {
      if ((*is_visited)[other] != 0 || plane.CosineOf(points[other]) < parameters.min_cosine ||
          plane.DistanceOf(points[other]) > parameters.max_distance_m) {
        return;
      }
      (*is_visited)[other] = 1;
      plane.Add(points[other]);
      region.push_back(other);
    });
  }
  return region;
}

/// The voxels of an object, each with the number of its part.
class VoxelParts {
 public:
  VoxelParts(const TrackedObject& object, const VoxelScale& scale) : scale_(scale) {
    object.volume().ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
      LeafParts& parts = leaves_[origin];
      parts.fill(kUnobserved);
      ForEachBit(leaf.observed, [&](std::size_t offset) { parts[offset] = kNone; });
    });
  }

  void AddSeed(const Eigen::Vector3d& position_object, std::size_t part) {
    Reach((position_object / scale_.voxel_size_m).array().round().cast<int>(), part);
  }

  /// Gives every voxel the part of the seed that reaches it first.
  void Spread() {
    static const std::array<Eigen::Vector3i, 6> kSteps = {Eigen::Vector3i(1, 0, 0),
                                                          Eigen::Vector3i(-1, 0, 0),
                                                          Eigen::Vector3i(0, 1, 0),
                                                          Eigen::Vector3i(0, -1, 0),
                                                          Eigen::Vector3i(0, 0, 1),
                                                          Eigen::Vector3i(0, 0, -1)};
    for (std::size_t next = 0; next < reached_.size(); ++next) {
      const auto [voxel, part] = reached_[next];
      for (const Eigen::Vector3i& step : kSteps) Reach(voxel + step, part);
    }
  }

  /// Returns the part of an observed voxel; 0 if no seed reaches it.
  std::size_t PartAt(LeafOrigin origin, std::size_t offset) const {
    const std::size_t part = leaves_.at(origin)[offset];
    return part == kNone ? 0 : part;
  }

 private:
  using LeafParts = std::array<std::size_t, kLeafVoxels>;

  static constexpr std::size_t kNone = ~std::size_t{0};
  static constexpr std::size_t kUnobserved = kNone - 1;

  void Reach(const Eigen::Vector3i& voxel, std::size_t part) {
    const LeafOrigin origin = LeafOf(voxel.x(), voxel.y(), voxel.z());
    // Most steps stay in a leaf.
    if (leaf_ == nullptr || origin != leaf_origin_) {
      const auto found = leaves_.find(origin);
      if (found == leaves_.end()) return;
      leaf_origin_ = origin;
      leaf_ = &found->second;
    }
    std::size_t& part_at = (*leaf_)[OffsetInLeaf(voxel.x(), voxel.y(), voxel.z())];
    if (part_at != kNone) return;
    part_at = part;
    reached_.emplace_back(voxel, part);
  }

  VoxelScale scale_;
  std::unordered_map<LeafOrigin, LeafParts> leaves_;
  LeafOrigin leaf_origin_;  ///< Of the last voxel.
  LeafParts* leaf_ = nullptr;
  std::vector<std::pair<Eigen::Vector3i, std::size_t>> reached_;
};

void CopyVoxel(const LeafVoxels& from, std::size_t offset, LeafVoxels* into) {
  into->voxels[offset] = from.voxels[offset];
  into->color[offset] = from.color[offset];
  into->has_color = from.has_color;
  SetBit(offset, &into->observed);
}

/// Resets the scores of evidence cells without surface, which another object has now.
void DropScoresWithoutSurface(TrackedObject* object, WorkingMap* map) {
  std::map<LeafOrigin, std::uint64_t> occupied;
  for (const SurfaceLeaf& leaf : object->surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      occupied[leaf.origin] |= std::uint64_t{1} << point.cell();
    }
  }
  ObjectEdit edit = map->Edit(object);
  for (LeafEvidence& leaf : edit.state().evidence.leaves) {
    const auto found = occupied.find(leaf.origin);
    const std::uint64_t cells = found == occupied.end() ? 0 : found->second;
    for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
      if ((cells >> cell & 1) == 0) leaf.score[cell] = 0;
    }
  }
}

}  // namespace

std::vector<OrientedPoint> OrientedSurfaceOf(const TrackedObject& object) {
  const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
  std::vector<OrientedPoint> points;
  points.reserve(object.surface().point_count());
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      points.push_back({T_world_object * point.position_object.cast<double>(),
                        T_world_object.linear() * point.normal_object.cast<double>()});
    }
  }
  return points;
}

std::vector<OrientedPoint> PointsAt(std::span<const OrientedPoint> points,
                                    std::span<const std::size_t> indices) {
  std::vector<OrientedPoint> chosen;
  chosen.reserve(indices.size());
  for (const std::size_t i : indices) chosen.push_back(points[i]);
  return chosen;
}

std::vector<double> SurfaceWeightsOf(const TrackedObject& object) {
  std::vector<double> weights;
  weights.reserve(object.surface().point_count());
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    const LeafView view = object.volume().FindLeaf(leaf.origin);
    for (const SurfaceVoxel& point : leaf.points) {
      weights.push_back(static_cast<double>(view.voxels[point.offset].weight()));
    }
  }
  return weights;
}

PrincipalAxes PrincipalAxesOf(std::span<const OrientedPoint> points) {
  if (points.empty()) return {};
  const auto count = static_cast<double>(points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const OrientedPoint& point : points) mean += point.position_world;
  mean /= count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const OrientedPoint& point : points) {
    const Eigen::Vector3d offset = point.position_world - mean;
    scatter += offset * offset.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(Eigen::Matrix3d(scatter / count));
  PrincipalAxes axes;
  axes.axes = solver.eigenvectors().rowwise().reverse();
  // Points evenly spread over a length have the twelfth part of its square as variance.
  axes.lengths_m = (12.0 * solver.eigenvalues().reverse().cwiseMax(0.0)).cwiseSqrt();
  Eigen::AlignedBox3d along_axes;
  for (const OrientedPoint& point : points) {
    along_axes.extend(axes.axes.transpose() * point.position_world);
  }
  axes.extents_m = along_axes.sizes();
  return axes;
}

std::vector<std::vector<std::size_t>> FindConnectedParts(std::span<const OrientedPoint> points,
                                                         const std::vector<char>& is_excluded,
                                                         double reach_m) {
  const PointGrid grid(points, reach_m);
  std::vector<char> is_visited = is_excluded;
  std::vector<std::vector<std::size_t>> parts;
  for (std::size_t seed = 0; seed < points.size(); ++seed) {
    if (is_visited[seed] != 0) continue;
    is_visited[seed] = 1;
    std::vector<std::size_t>& part = parts.emplace_back(1, seed);
    for (std::size_t next = 0; next < part.size(); ++next) {
      grid.ForEachNeighbour(part[next], [&](std::size_t other) {
        if (is_visited[other] != 0) return;
        is_visited[other] = 1;
        part.push_back(other);
      });
    }
    std::sort(part.begin(), part.end());
  }
  std::stable_sort(
      parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return parts;
}

double InwardTurn(const OrientedPoint& from, const OrientedPoint& to) {
  const Eigen::Vector3d way = (to.position_world - from.position_world).normalized();
  return std::max(0.0, way.dot(from.normal_world - to.normal_world)) / M_SQRT2;
}

std::vector<std::size_t> SpreadParts(std::span<const OrientedPoint> points,
                                     std::span<const std::pair<std::size_t, std::size_t>> seeds,
                                     double reach_m,
                                     double concave_cost_m) {
  // Dijkstra's algorithm, from all seeds at once.
  const PointGrid grid(points, reach_m);
  std::vector<std::size_t> part_of(points.size(), 0);
  std::vector<double> way_m(points.size(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, std::size_t>;  // The way and the point.
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> reached;
  for (const auto& [point, part] : seeds) {
    part_of[point] = part;
    way_m[point] = 0.0;
    reached.emplace(0.0, point);
  }
  while (!reached.empty()) {
    const auto [from_m, from] = reached.top();
    reached.pop();
    if (from_m > way_m[from]) continue;
    grid.ForEachNeighbour(from, [&, from_m = from_m, from = from](std::size_t other) {
      const double to_m = from_m +
                          (points[other].position_world - points[from].position_world).norm() +
                          concave_cost_m * InwardTurn(points[from], points[other]);
      if (to_m >= way_m[other]) return;
      way_m[other] = to_m;
      part_of[other] = part_of[from];
      reached.emplace(to_m, other);
    });
  }
  return part_of;
}

std::vector<PlanePart> FindPlaneParts(std::span<const OrientedPoint> points,
                                      double point_area_m2,
                                      double reach_m,
                                      const PlaneParameters& parameters) {
  const PointGrid grid(points, reach_m);
  std::vector<char> is_visited(points.size(), 0);
  std::vector<PlanePart> planes;
  for (std::size_t seed = 0; seed < points.size(); ++seed) {
    if (is_visited[seed] != 0) continue;
    std::vector<std::size_t> region = GrowPlane(points, grid, seed, parameters, &is_visited);
    if (region.size() < kMinSeedPoints) {
      // A noisy normal grows nothing; the point may be part of a plane that another seed grows.
      for (const std::size_t index : region) is_visited[index] = index == seed ? 1 : 0;
      continue;
    }
    if (static_cast<double>(region.size()) * point_area_m2 < parameters.min_area_m2) continue;
    Eigen::Vector3d normal_sum = Eigen::Vector3d::Zero();
    Eigen::Vector3d position_sum = Eigen::Vector3d::Zero();
    for (const std::size_t index : region) {
      normal_sum += points[index].normal_world;
      position_sum += points[index].position_world;
    }
    const Eigen::Vector3d center = position_sum / static_cast<double>(region.size());
    planes.push_back({normal_sum.normalized(), center, std::move(region)});
  }
  return planes;
}

std::vector<TrackedObject*> DivideVoxels(TrackedObject* object,
                                         std::span<const std::size_t> part_of,
                                         std::size_t part_count,
                                         WorkingMap* map) {
  VoxelParts voxel_parts(*object, map->scale());
  std::size_t index = 0;
  std::vector<LeafOrigin> origins;
  for (const SurfaceLeaf& leaf : object->surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      voxel_parts.AddSeed(point.position_object.cast<double>(), part_of[index++]);
    }
  }
  voxel_parts.Spread();
  object->volume().ForEachLeaf(
      [&](LeafOrigin origin, const LeafView&) { origins.push_back(origin); });
  std::vector<TrackedObject*> objects;
  for (std::size_t part = 1; part <= part_count; ++part) {
    TrackedObject& added = map->AddPart(*object);
    objects.push_back(&added);
    ObjectEdit edit = map->Edit(&added);
    LeafVoxels whole;
    for (const LeafOrigin& origin : origins) {
      object->volume().LoadLeaf(origin, &whole);
      LeafVoxels voxels{};
      ForEachBit(whole.observed, [&](std::size_t offset) {
        if (voxel_parts.PartAt(origin, offset) == part) CopyVoxel(whole, offset, &voxels);
      });
      if (voxels.observed == LeafMask{}) continue;
      edit.StoreLeaf(origin, voxels);
      const LeafEvidence* evidence = object->state().evidence.FindLeaf(origin);
      if (evidence != nullptr) edit.state().evidence.MutableLeaf(origin) = *evidence;
    }
  }
  {
    ObjectEdit edit = map->Edit(object);
    LeafVoxels whole;
    for (const LeafOrigin& origin : origins) {
      object->volume().LoadLeaf(origin, &whole);
      LeafVoxels voxels{};
      ForEachBit(whole.observed, [&](std::size_t offset) {
        if (voxel_parts.PartAt(origin, offset) == 0) CopyVoxel(whole, offset, &voxels);
      });
      if (voxels.observed != whole.observed) edit.StoreLeaf(origin, voxels);
    }
  }
  DropScoresWithoutSurface(object, map);
  for (TrackedObject* part : objects) DropScoresWithoutSurface(part, map);
  return objects;
}

}  // namespace steadymap
