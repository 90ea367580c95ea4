#include "core/objects/scene_structure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <utility>

#include <Eigen/Core>

#include "core/objects/outline.h"
#include "core/objects/point_grid.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Where the continuation of a surface is looked for along an axis in its plane, voxels.
constexpr double kContinuationVoxels[] = {2.0, -2.0, 4.0, -4.0, 6.0, -6.0};

// Neighbours on a plane, voxels: the diagonal of a voxel.
constexpr double kPlaneReachVoxels = 1.75;

/// The search for the structure of one scene.
class StructureSearch {
 public:
  StructureSearch(const SceneDivisionParameters& parameters,
                  const SurfaceMatchParameters& surface,
                  std::span<const OrientedPoint> points,
                  const WorkingMap& map)
      : parameters_(parameters),
        surface_(surface),
        voxel_m_(map.scale().voxel_size_m),
        points_(points),
        map_(map),
        background_(map.background(), map.scale()),
        grid_(points, kPlaneReachVoxels * voxel_m_),
        kinds_(points.size(), ScenePointKind::kThing) {}

  std::vector<ScenePointKind> Run() {
    const std::vector<PlanePart> planes = FindLargePlanes();
    for (const PlanePart& plane : planes) {
      for (const std::size_t point : plane.points) kinds_[point] = ScenePointKind::kStructure;
    }
    MarkFloor(planes);
    MarkEdges(planes);
    MarkKnown();
    MarkContinuations();
    MarkFeet();
    return std::move(kinds_);
  }

 private:
  std::vector<PlanePart> FindLargePlanes() const;
  std::vector<PlanePart> JoinPieces(std::vector<PlanePart> pieces) const;
  void MarkFloor(const std::vector<PlanePart>& planes);
  void MarkEdges(const std::vector<PlanePart>& planes);
  void MarkEdge(const PlanePart& a, const PlanePart& b);
  void MarkKnown();
  void MarkContinuations();
  void MarkPlane(std::size_t seed);
  bool Continues(const OrientedPoint& point);
  bool ContinuesAlong(const Eigen::Vector3d& axis, const OrientedPoint& point);
  void MarkFeet();
  bool IsFoot(std::size_t index);

  /// True if a position is within a voxel of the plane through a point.
  bool IsNearPlane(const Eigen::Vector3d& position_world, const OrientedPoint& plane) const {
    return std::abs(plane.normal_world.dot(position_world - plane.position_world)) <= voxel_m_;
  }

  bool IsOnPlane(const OrientedPoint& point, const OrientedPoint& plane) const {
    return IsNearPlane(point.position_world, plane) &&
           plane.normal_world.dot(point.normal_world) >= parameters_.min_plane_cosine;
  }

  bool IsLevel(const Eigen::Vector3d& normal_world) const {
    return normal_world.z() >= parameters_.min_plane_cosine;
  }

  static OrientedPoint CenterOf(const PlanePart& plane) {
    return {plane.center_world, plane.normal_world};
  }

  bool IsStructure(std::size_t i) const { return kinds_[i] == ScenePointKind::kStructure; }

  const SceneDivisionParameters& parameters_;
  const SurfaceMatchParameters& surface_;
  double voxel_m_;
  std::span<const OrientedPoint> points_;
  const WorkingMap& map_;
  TsdfSampler background_;
  PointGrid grid_;  ///< Of all points; finds the neighbours on a plane.
  std::vector<ScenePointKind> kinds_;
};

/// Finds large planes, except those that end in free space, such as the top of a table or the front
/// of a cabinet.
std::vector<PlanePart> StructureSearch::FindLargePlanes() const {
  const OutlineTest test(map_, {});
  std::vector<PlanePart> planes = JoinPieces(FindScenePlanes(parameters_, points_, 0.0, voxel_m_));
  std::erase_if(planes, [&](const PlanePart& plane) {
    const double area_m2 = static_cast<double>(plane.points.size()) * voxel_m_ * voxel_m_;
    return area_m2 < parameters_.min_plane_area_m2 ||
           test.FreeShareOf(PointsAt(points_, plane.points)) > 0.5;
  });
  return planes;
}

/// Joins the pieces of each plane: things divide a floor or a wall into pieces, each of which may
/// be small. The largest piece tells where the plane is.
std::vector<PlanePart> StructureSearch::JoinPieces(std::vector<PlanePart> pieces) const {
  std::stable_sort(pieces.begin(), pieces.end(), [](const PlanePart& a, const PlanePart& b) {
    return a.points.size() > b.points.size();
  });
  std::vector<PlanePart> planes;
  for (PlanePart& piece : pieces) {
    const auto plane = std::find_if(planes.begin(), planes.end(), [&](const PlanePart& other) {
      return IsOnPlane(CenterOf(piece), CenterOf(other));
    });
    if (plane == planes.end()) {
      planes.push_back(std::move(piece));
    } else {
      plane->points.insert(plane->points.end(), piece.points.begin(), piece.points.end());
    }
  }
  return planes;
}

/// Marks all points on the lowest of the large level planes: a piece of a floor may be too small to
/// be found as a plane.
void StructureSearch::MarkFloor(const std::vector<PlanePart>& planes) {
  std::optional<OrientedPoint> floor;
  for (const PlanePart& plane : planes) {
    if (!IsLevel(plane.normal_world)) continue;
    if (!floor || plane.center_world.z() < floor->position_world.z()) floor = CenterOf(plane);
  }
  if (!floor) return;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (IsOnPlane(points_[i], *floor)) kinds_[i] = ScenePointKind::kStructure;
  }
}

/// Marks the points on the edges where two large planes meet: there normals turn from that of one
/// to that of the other.
void StructureSearch::MarkEdges(const std::vector<PlanePart>& planes) {
  for (std::size_t i = 0; i < planes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) MarkEdge(planes[i], planes[j]);
  }
}

void StructureSearch::MarkEdge(const PlanePart& a, const PlanePart& b) {
  const Eigen::Vector3d between = (a.normal_world + b.normal_world).normalized();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const OrientedPoint& point = points_[i];
    if (IsNearPlane(point.position_world, CenterOf(a)) &&
        IsNearPlane(point.position_world, CenterOf(b)) &&
        between.dot(point.normal_world) >= parameters_.min_plane_cosine) {
      kinds_[i] = ScenePointKind::kStructure;
    }
  }
}

/// Marks the points on known background. Noise makes points on the back of a wall, too.
void StructureSearch::MarkKnown() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const DistanceSample sample = background_.Sample(points_[i].position_world);
    if (sample.known && std::abs(sample.distance_m) <= surface_.contact_voxels * voxel_m_ &&
        std::abs(sample.gradient.dot(points_[i].normal_world)) >= surface_.min_normal_cosine) {
      kinds_[i] = ScenePointKind::kStructure;
    }
  }
}

/// Marks the points that continue known background in its plane: floor that was hidden until now.
void StructureSearch::MarkContinuations() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!IsStructure(i) && Continues(points_[i])) MarkPlane(i);
  }
}

/// Marks the points that are connected with `seed` on a plane.
void StructureSearch::MarkPlane(std::size_t seed) {
  kinds_[seed] = ScenePointKind::kStructure;
  std::vector<std::size_t> region = {seed};
  for (std::size_t next = 0; next < region.size(); ++next) {
    grid_.ForEachNeighbour(region[next], [&](std::size_t other) {
      if (IsStructure(other) || !IsOnPlane(points_[other], points_[seed])) return;
      kinds_[other] = ScenePointKind::kStructure;
      region.push_back(other);
    });
  }
}

/// True if the background continues a surface at a point: along two axes in its tangent plane, a
/// few voxels away, it has surface that faces alike. Along an edge, it has some along one axis.
bool StructureSearch::Continues(const OrientedPoint& point) {
  const Eigen::Vector3d along = point.normal_world.unitOrthogonal();
  return ContinuesAlong(along, point) && ContinuesAlong(point.normal_world.cross(along), point);
}

bool StructureSearch::ContinuesAlong(const Eigen::Vector3d& axis, const OrientedPoint& point) {
  return std::any_of(
      std::begin(kContinuationVoxels), std::end(kContinuationVoxels), [&](double voxels) {
        const DistanceSample sample =
            background_.Sample(point.position_world + voxels * voxel_m_ * axis);
        return sample.known && std::abs(sample.distance_m) <= voxel_m_ &&
               sample.gradient.dot(point.normal_world) > parameters_.min_plane_cosine;
      });
}

void StructureSearch::MarkFeet() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!IsStructure(i) && IsFoot(i)) kinds_[i] = ScenePointKind::kFoot;
  }
}

bool StructureSearch::IsFoot(std::size_t index) {
  const Eigen::Vector3d& position_world = points_[index].position_world;
  bool is_foot = false;
  grid_.ForEachNeighbour(index, [&](std::size_t other) {
    is_foot = is_foot || (IsStructure(other) && IsLevel(points_[other].normal_world) &&
                          IsNearPlane(position_world, points_[other]));
  });
  if (is_foot) return true;
  const DistanceSample sample = background_.Sample(position_world);
  return sample.known && std::abs(sample.distance_m) <= voxel_m_ && IsLevel(sample.gradient);
}

}  // namespace

std::vector<ScenePointKind> FindSceneStructure(const SceneDivisionParameters& parameters,
                                               const SurfaceMatchParameters& surface,
                                               std::span<const OrientedPoint> points,
                                               const WorkingMap& map) {
  return StructureSearch(parameters, surface, points, map).Run();
}

std::vector<PlanePart> FindScenePlanes(const SceneDivisionParameters& parameters,
                                       std::span<const OrientedPoint> points,
                                       double min_area_m2,
                                       double voxel_m) {
  return FindPlaneParts(points,
                        voxel_m * voxel_m,
                        kPlaneReachVoxels * voxel_m,
                        {min_area_m2, voxel_m, parameters.min_plane_cosine});
}

}  // namespace steadymap
