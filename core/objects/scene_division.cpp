#include "core/objects/scene_division.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/objects/gap_planes.h"
#include "core/objects/outline.h"
#include "core/objects/point_grid.h"
#include "core/objects/surface_parts.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Where the continuation of a surface is looked for along an axis in its plane, voxels.
constexpr double kContinuationVoxels[] = {2.0, -2.0, 4.0, -4.0, 6.0, -6.0};

// Neighbours on a plane, voxels: the diagonal of a voxel.
constexpr double kPlaneReachVoxels = 1.75;

/// The division of one scene.
class SceneDivision {
 public:
  SceneDivision(const SceneDivisionParameters& parameters,
                const SurfaceMatchParameters& surface,
                const TrackedObject& scene,
                WorkingMap* map)
      : parameters_(parameters),
        surface_(surface),
        voxel_m_(map->scale().voxel_size_m),
        points_(OrientedSurfaceOf(scene)),
        weights_(SurfaceWeightsOf(scene)) {
    FindStructure(*map);
    FindKnownStructures(map);
    FindParts();
    DivideAtGaps(scene.state().gaps);
    DropHardlySeenParts();
    DropSlenderParts();
    DropIncompleteParts(*map);
  }

  /// Returns the part of each surface point, in the order of `OrientedSurfaceOf`; 0: background.
  std::vector<std::size_t> PartOfPoints() const {
    std::vector<std::size_t> part_of(points_.size(), 0);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      for (const std::size_t point : parts_[i]) part_of[point] = i + 1;
    }
    return part_of;
  }

  std::size_t part_count() const { return parts_.size(); }

 private:
  /// Finds the plane parts of at least that area.
  std::vector<PlanePart> FindPlanes(const std::vector<OrientedPoint>& points,
                                    double min_area_m2) const {
    return FindPlaneParts(points,
                          voxel_m_ * voxel_m_,
                          kPlaneReachVoxels * voxel_m_,
                          {min_area_m2, voxel_m_, parameters_.min_plane_cosine});
  }

  /// Marks the points on large planes and on known background. Noise makes points on the back of a
  /// wall, too.
  void FindStructure(const WorkingMap& map) {
    is_structure_.assign(points_.size(), 0);
    const std::vector<PlanePart> planes = FindLargePlanes(map);
    for (const PlanePart& plane : planes) {
      for (const std::size_t point : plane.points) is_structure_[point] = 1;
    }
    MarkFloor(planes);
    TsdfSampler sampler(map.background(), map.scale());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const DistanceSample sample = sampler.Sample(points_[i].position_world);
      if (sample.known && std::abs(sample.distance_m) <= surface_.contact_voxels * voxel_m_ &&
          std::abs(sample.gradient.dot(points_[i].normal_world)) >= surface_.min_normal_cosine) {
        is_structure_[i] = 1;
      }
    }
    ExtendStructure(&sampler);
  }

  /// Finds large planes, except those that end in free space, such as the top of a table or the
  /// front of a cabinet.
  std::vector<PlanePart> FindLargePlanes(const WorkingMap& map) const {
    const OutlineTest test(map, {});
    std::vector<PlanePart> planes = JoinPieces(FindPlanes(points_, 0.0));
    std::erase_if(planes, [&](const PlanePart& plane) {
      return AreaOf(plane) < parameters_.min_plane_area_m2 ||
             test.FreeShareOf(PointsOf(plane.points)) > 0.5;
    });
    return planes;
  }

  /// Marks all points on the lowest of the large level planes: a piece of a floor may be too small
  /// to be found as a plane.
  void MarkFloor(const std::vector<PlanePart>& planes) {
    std::optional<OrientedPoint> floor;
    for (const PlanePart& plane : planes) {
      if (plane.normal_world.z() < parameters_.min_plane_cosine) continue;
      if (!floor || plane.center_world.z() < floor->position_world.z()) {
        floor = OrientedPoint{plane.center_world, plane.normal_world};
      }
    }
    if (!floor) return;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (IsOnPlane(points_[i], *floor)) is_structure_[i] = 1;
    }
  }

  /// Joins the pieces of each plane: things divide a floor or a wall into pieces, each of which may
  /// be small. The largest piece tells where the plane is.
  std::vector<PlanePart> JoinPieces(std::vector<PlanePart> pieces) const {
    std::stable_sort(pieces.begin(), pieces.end(), [](const PlanePart& a, const PlanePart& b) {
      return a.points.size() > b.points.size();
    });
    std::vector<PlanePart> planes;
    for (PlanePart& piece : pieces) {
      const auto plane = std::find_if(planes.begin(), planes.end(), [&](const PlanePart& other) {
        return IsOnPlane({piece.center_world, piece.normal_world},
                         {other.center_world, other.normal_world});
      });
      if (plane == planes.end()) {
        planes.push_back(std::move(piece));
      } else {
        plane->points.insert(plane->points.end(), piece.points.begin(), piece.points.end());
      }
    }
    return planes;
  }

  double AreaOf(const PlanePart& plane) const {
    return static_cast<double>(plane.points.size()) * voxel_m_ * voxel_m_;
  }

  /// Adds the surface of known structures to the supports.
  void FindKnownStructures(WorkingMap* map) {
    for (const TrackedObject* object : map->AllObjects()) {
      if (!IsStructure(*object, parameters_)) continue;
      const std::vector<OrientedPoint> points = OrientedSurfaceOf(*object);
      supports_.insert(supports_.end(), points.begin(), points.end());
    }
  }

  /// Marks the points that continue known background in its plane: floor that was hidden until now.
  void ExtendStructure(TsdfSampler* background) {
    const PointGrid grid(points_, kPlaneReachVoxels * voxel_m_);
    for (std::size_t seed = 0; seed < points_.size(); ++seed) {
      if (is_structure_[seed] == 0 && ContinuesAt(points_[seed], background)) {
        MarkPlane(points_[seed], seed, grid);
      }
    }
  }

  /// Marks the points that are connected with `seed` on a plane.
  void MarkPlane(const OrientedPoint& plane, std::size_t seed, const PointGrid& grid) {
    is_structure_[seed] = 1;
    std::vector<std::size_t> region = {seed};
    for (std::size_t next = 0; next < region.size(); ++next) {
      grid.ForEachNeighbour(region[next], [&](std::size_t other) {
        if (is_structure_[other] != 0 || !IsOnPlane(points_[other], plane)) return;
        is_structure_[other] = 1;
        region.push_back(other);
      });
    }
  }

  bool IsOnPlane(const OrientedPoint& point, const OrientedPoint& plane) const {
    const double distance_m = plane.normal_world.dot(point.position_world - plane.position_world);
    return std::abs(distance_m) <= voxel_m_ &&
           plane.normal_world.dot(point.normal_world) >= parameters_.min_plane_cosine;
  }

  void FindParts() {
    const double contact_m = surface_.contact_voxels * voxel_m_;
    parts_ = FindConnectedParts(points_, is_structure_, contact_m);
    DropHardlySeenParts();
    JoinNearParts(parameters_.near_voxels * voxel_m_);
    for (std::size_t i = parts_.size(); i-- > 0;) SeparateStanding(i, contact_m);
  }

  /// Divides parts at the gaps between things beside each other.
  void DivideAtGaps(const std::vector<SeenGap>& seen) {
    for (const GapPlane& gap : FindGapPlanes(parameters_.gaps, seen, voxel_m_)) {
      for (std::size_t i = parts_.size(); i-- > 0;) {
        if (!Divides(gap, PointsOf(parts_[i]), voxel_m_)) continue;
        std::vector<std::size_t> part = std::move(parts_[i]);
        const auto behind = std::stable_partition(part.begin(), part.end(), [&](std::size_t point) {
          return gap.DistanceOf(points_[point].position_world) < 0.0;
        });
        parts_.emplace_back(behind, part.end());
        part.erase(behind, part.end());
        parts_[i] = std::move(part);
      }
    }
  }

  /// Makes parts of what stands on level surface of a part, such as on a table.
  void SeparateStanding(std::size_t index, double contact_m) {
    const std::vector<std::size_t> part = parts_[index];
    const std::vector<OrientedPoint> points = PointsOf(part);
    std::vector<char> is_support(points.size(), 0);
    for (const PlanePart& plane : FindPlanes(points, parameters_.min_support_area_m2)) {
      for (const std::size_t i : plane.points) {
        if (points[i].normal_world.z() <= parameters_.min_plane_cosine) continue;
        is_support[i] = 1;
        supports_.push_back(points[i]);
      }
    }
    std::vector<char> is_separate(points.size(), 0);
    for (const std::vector<std::size_t>& region :
         FindConnectedParts(points, is_support, contact_m)) {
      std::vector<std::size_t> standing;
      standing.reserve(region.size());
      for (const std::size_t i : region) standing.push_back(part[i]);
      if (IsHardlySeen(standing) || !StandsOn(points, region, is_support)) continue;
      for (const std::size_t i : region) is_separate[i] = 1;
      parts_.push_back(std::move(standing));
    }
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (is_separate[i] == 0) rest.push_back(part[i]);
    }
    parts_[index] = std::move(rest);
  }

  /// True if a region of a part ends, at its lowest points, beside level surface of the part.
  bool StandsOn(const std::vector<OrientedPoint>& points,
                const std::vector<std::size_t>& region,
                const std::vector<char>& is_support) const {
    double lowest_m = std::numeric_limits<double>::max();
    for (const std::size_t i : region) lowest_m = std::min(lowest_m, points[i].position_world.z());
    std::vector<std::size_t> foot;
    std::copy_if(region.begin(), region.end(), std::back_inserter(foot), [&](std::size_t i) {
      return points[i].position_world.z() <= lowest_m + voxel_m_;
    });
    const double reach_m = parameters_.near_voxels * voxel_m_;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (is_support[i] == 0) continue;
      const double height_m = lowest_m - points[i].position_world.z();
      if (height_m < -voxel_m_ || height_m > reach_m) continue;
      if (std::any_of(foot.begin(), foot.end(), [&](std::size_t j) {
            return (points[i].position_world - points[j].position_world).norm() <= reach_m;
          })) {
        return true;
      }
    }
    return false;
  }

  /// Joins parts that are closer than `reach_m`, each of which is large enough for an object.
  void JoinNearParts(double reach_m) {
    constexpr std::size_t kNone = ~std::size_t{0};
    const PointGrid grid(points_, reach_m);
    std::vector<std::size_t> part_of(points_.size(), kNone);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      for (const std::size_t point : parts_[i]) part_of[point] = i;
    }
    for (std::size_t i = parts_.size(); i-- > 0;) {
      std::size_t into = i;
      for (const std::size_t point : parts_[i]) {
        grid.ForEachNeighbour(point, [&](std::size_t other) {
          if (part_of[other] < into) into = part_of[other];
        });
      }
      if (into == i) continue;
      for (const std::size_t point : parts_[i]) part_of[point] = into;
      Join(i, into);
    }
  }

  /// True if the background continues a surface at a point: along two axes in its tangent plane, a
  /// few voxels away, it has surface that faces alike. Along an edge, it has some along one axis.
  bool ContinuesAt(const OrientedPoint& point, TsdfSampler* background) const {
    const Eigen::Vector3d along = point.normal_world.unitOrthogonal();
    return ContinuesAlong(along, point, background) &&
           ContinuesAlong(point.normal_world.cross(along), point, background);
  }

  bool ContinuesAlong(const Eigen::Vector3d& axis,
                      const OrientedPoint& point,
                      TsdfSampler* background) const {
    return std::any_of(
        std::begin(kContinuationVoxels), std::end(kContinuationVoxels), [&](double voxels) {
          const DistanceSample sample =
              background->Sample(point.position_world + voxels * voxel_m_ * axis);
          return sample.known && std::abs(sample.distance_m) <= voxel_m_ &&
                 sample.gradient.dot(point.normal_world) > parameters_.min_plane_cosine;
        });
  }

  std::vector<OrientedPoint> PointsOf(const std::vector<std::size_t>& part) const {
    std::vector<OrientedPoint> points;
    points.reserve(part.size());
    for (const std::size_t i : part) points.push_back(points_[i]);
    return points;
  }

  /// Drops parts of which most of the outline was not seen.
  void DropIncompleteParts(const WorkingMap& map) {
    std::vector<Eigen::Vector3d> structure;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (is_structure_[i] != 0) structure.push_back(points_[i].position_world);
    }
    for (const OrientedPoint& point : supports_) structure.push_back(point.position_world);
    const OutlineTest test(map, structure);
    std::erase_if(parts_, [&](const std::vector<std::size_t>& part) {
      return test.UnseenShareOf(PointsOf(part)) > 0.5;
    });
  }

  /// True if so little of a part was seen, or from so far, that it may be noise of the depth. A
  /// weight grows with the number of measurements and falls with the square of their distance.
  bool IsHardlySeen(const std::vector<std::size_t>& part) const {
    double weight = 0.0;
    for (const std::size_t i : part) weight += weights_[i];
    return weight * voxel_m_ * voxel_m_ < parameters_.min_weighted_area_m2;
  }

  void DropHardlySeenParts() {
    std::erase_if(parts_, [&](const std::vector<std::size_t>& part) { return IsHardlySeen(part); });
  }

  /// Drops parts that the voxels are too coarse for.
  void DropSlenderParts() {
    const double min_width_m = parameters_.min_width_voxels * voxel_m_;
    std::erase_if(parts_, [&](const std::vector<std::size_t>& part) {
      const PrincipalAxes axes = PrincipalAxesOf(PointsOf(part));
      if (axes.lengths_m.y() < min_width_m) return true;
      // Points on the outside of a leg alone are farther apart than in a box full of points.
      const Eigen::Vector3d& extents_m = axes.extents_m;
      return extents_m.y() < min_width_m &&
             extents_m.y() < parameters_.max_leg_share * extents_m.x();
    });
  }

  void Join(std::size_t part, std::size_t into) {
    parts_[into].insert(parts_[into].end(), parts_[part].begin(), parts_[part].end());
    parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(part));
  }

  const SceneDivisionParameters& parameters_;
  const SurfaceMatchParameters& surface_;
  double voxel_m_;
  std::vector<OrientedPoint> points_;
  std::vector<double> weights_;  ///< Of the voxels of the points.
  std::vector<char> is_structure_;
  std::vector<OrientedPoint> supports_;  ///< On which things stand, besides structure.
  std::vector<std::vector<std::size_t>> parts_;
};

/// Adds the voxels of an object that the background has not observed to the background.
void GiveToBackground(const TrackedObject& object, WorkingMap* map) {
  const Eigen::Vector3d offset_voxels =
      object.state().T_world_object.position_world / map->scale().voxel_size_m;
  const Eigen::Vector3i shift = offset_voxels.array().round().cast<int>();
  object.volume().ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    const LeafOrigin target{origin.x + shift.x(), origin.y + shift.y(), origin.z + shift.z()};
    LeafVoxels voxels;
    CopyLeaf(map->background().FindLeaf(target), &voxels);
    bool has_changed = false;
    ForEachBit(leaf.observed, [&](std::size_t offset) {
      if (IsSet(voxels.observed, offset)) return;
      voxels.voxels[offset] = leaf.voxels[offset];
      if (leaf.color != nullptr) {
        voxels.color[offset] = leaf.color[offset];
        voxels.has_color = true;
      }
      SetBit(offset, &voxels.observed);
      has_changed = true;
    });
    if (has_changed) map->StoreBackgroundLeaf(target, voxels);
  });
}

}  // namespace

bool IsStructure(const TrackedObject& object, const SceneDivisionParameters& parameters) {
  return object.state().status == ObjectStatus::kPresent && !HasGivenExtent(object.state()) &&
         object.SurfaceAreaM2() >= parameters.min_plane_area_m2;
}

void DivideScene(const SceneDivisionParameters& parameters,
                 const SurfaceMatchParameters& surface,
                 TrackedObject* scene,
                 WorkingMap* map) {
  const SceneDivision division(parameters, surface, *scene, map);
  DivideVoxels(scene, division.PartOfPoints(), division.part_count(), map);
  GiveToBackground(*scene, map);
  map->Delete(scene);
}

}  // namespace steadymap
