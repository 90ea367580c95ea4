#include "core/objects/scene_division.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "core/objects/gap_planes.h"
#include "core/objects/outline.h"
#include "core/objects/point_grid.h"
#include "core/objects/scene_structure.h"
#include "core/objects/surface_parts.h"

namespace steadymap {
namespace {

// Surfaces face each other if their normals turn inwards from one to the other by more than this
// share of a right angle.
constexpr double kFacingTurn = 0.5;

/// True if two points of surfaces face each other, as across the gap between two things.
bool FaceEachOther(const OrientedPoint& a, const OrientedPoint& b) {
  return InwardTurn(a, b) > kFacingTurn;
}

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
    kinds_ = FindSceneStructure(parameters, surface, points_, *map);
    FindKnownStructures(map);
    FindParts();
    DivideAtGaps(scene.state().gaps);
    DropHardlySeenParts();
    DropSlenderParts();
    SeparateStanding();
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
  /// Adds the surface of known structures to the supports.
  void FindKnownStructures(WorkingMap* map) {
    for (const TrackedObject* object : map->AllObjects()) {
      if (!IsStructure(*object, parameters_)) continue;
      const std::vector<OrientedPoint> points = OrientedSurfaceOf(*object);
      supports_.insert(supports_.end(), points.begin(), points.end());
    }
  }

  void FindParts() {
    std::vector<char> is_excluded(points_.size(), 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (kinds_[i] != ScenePointKind::kThing) is_excluded[i] = 1;
    }
    parts_ = FindConnectedParts(points_, is_excluded, ContactM());
    // Noise on the floor takes its own feet before it is dropped, so that no thing takes them.
    AddFeet(ContactM());
    DropHardlySeenParts();
    JoinNearParts(0);
  }

  /// Adds to each part the feet that it reaches first, in steps of at most `reach_m`.
  void AddFeet(double reach_m) {
    std::vector<std::size_t> part_of = PartOfPoints();
    std::vector<std::size_t> reached;
    for (const std::vector<std::size_t>& part : parts_) {
      reached.insert(reached.end(), part.begin(), part.end());
    }
    const PointGrid grid(points_, reach_m);
    for (std::size_t next = 0; next < reached.size(); ++next) {
      const std::size_t part = part_of[reached[next]];
      grid.ForEachNeighbour(reached[next], [&](std::size_t other) {
        if (part_of[other] != 0 || kinds_[other] != ScenePointKind::kFoot) return;
        part_of[other] = part;
        parts_[part - 1].push_back(other);
        reached.push_back(other);
      });
    }
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

  /// Makes parts of what stands on level surface of other parts, such as on a table.
  void SeparateStanding() {
    const std::size_t first = parts_.size();
    for (std::size_t i = first; i-- > 0;) SeparateStandingOn(i);
    JoinNearParts(first);
  }

  void SeparateStandingOn(std::size_t index) {
    const std::vector<std::size_t> part = parts_[index];
    const std::vector<OrientedPoint> points = PointsOf(part);
    std::vector<char> is_support(points.size(), 0);
    for (const PlanePart& plane :
         FindScenePlanes(parameters_, points, parameters_.min_support_area_m2, voxel_m_)) {
      for (const std::size_t i : plane.points) {
        if (points[i].normal_world.z() <= parameters_.min_plane_cosine) continue;
        is_support[i] = 1;
        supports_.push_back(points[i]);
      }
    }
    std::vector<char> is_separate(points.size(), 0);
    for (const std::vector<std::size_t>& region :
         FindConnectedParts(points, is_support, ContactM())) {
      std::vector<std::size_t> standing;
      standing.reserve(region.size());
      for (const std::size_t i : region) standing.push_back(part[i]);
      if (IsHardlySeen(standing) || IsLegShaped(standing) ||
          !StandsOn(points, region, is_support)) {
        continue;
      }
      for (const std::size_t i : region) is_separate[i] = 1;
      parts_.push_back(std::move(standing));
    }
    std::vector<std::size_t> rest;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (is_separate[i] == 0) rest.push_back(part[i]);
    }
    parts_[index] = std::move(rest);
  }

  /// True if a region of a part ends, at its lowest points, beside level surface of the part, and
  /// rises above that by more than the resolution of the map.
  bool StandsOn(const std::vector<OrientedPoint>& points,
                const std::vector<std::size_t>& region,
                const std::vector<char>& is_support) const {
    double lowest_m = std::numeric_limits<double>::max();
    double highest_m = std::numeric_limits<double>::lowest();
    for (const std::size_t i : region) {
      lowest_m = std::min(lowest_m, points[i].position_world.z());
      highest_m = std::max(highest_m, points[i].position_world.z());
    }
    std::vector<std::size_t> foot;
    std::copy_if(region.begin(), region.end(), std::back_inserter(foot), [&](std::size_t i) {
      return points[i].position_world.z() <= lowest_m + voxel_m_;
    });
    const double reach_m = parameters_.near_voxels * voxel_m_;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (is_support[i] == 0) continue;
      const double support_m = points[i].position_world.z();
      if (lowest_m < support_m - voxel_m_ || lowest_m > support_m + reach_m ||
          highest_m <= support_m + voxel_m_) {
        continue;
      }
      if (std::any_of(foot.begin(), foot.end(), [&](std::size_t j) {
            return (points[i].position_world - points[j].position_world).norm() <= reach_m;
          })) {
        return true;
      }
    }
    return false;
  }

  /// Joins the parts from index `first` on that are near each other, except where they face each
  /// other across a gap. The distance between their feet does not count.
  void JoinNearParts(std::size_t first) {
    constexpr std::size_t kNone = ~std::size_t{0};
    const PointGrid grid(points_, parameters_.near_voxels * voxel_m_);
    std::vector<std::size_t> part_of(points_.size(), kNone);
    for (std::size_t i = first; i < parts_.size(); ++i) {
      for (const std::size_t point : parts_[i]) {
        if (kinds_[point] == ScenePointKind::kThing) part_of[point] = i;
      }
    }
    for (std::size_t i = parts_.size(); i-- > first;) {
      // By part: how many more pairs of near points do not face each other than do.
      std::map<std::size_t, std::ptrdiff_t> balance;
      for (const std::size_t point : parts_[i]) {
        if (part_of[point] == kNone) continue;
        grid.ForEachNeighbour(point, [&](std::size_t other) {
          if (part_of[other] >= i) return;
          balance[part_of[other]] += FaceEachOther(points_[point], points_[other]) ? -1 : 1;
        });
      }
      const auto found = std::find_if(
          balance.begin(), balance.end(), [](const auto& entry) { return entry.second >= 0; });
      if (found == balance.end()) continue;
      const std::size_t into = found->first;
      for (const std::size_t point : parts_[i]) {
        if (part_of[point] != kNone) part_of[point] = into;
      }
      Join(i, into);
    }
  }

  double ContactM() const { return surface_.contact_voxels * voxel_m_; }

  std::vector<OrientedPoint> PointsOf(const std::vector<std::size_t>& part) const {
    return PointsAt(points_, part);
  }

  /// Drops parts of which most of the outline was not seen.
  void DropIncompleteParts(const WorkingMap& map) {
    std::vector<Eigen::Vector3d> structure;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (kinds_[i] == ScenePointKind::kStructure) structure.push_back(points_[i].position_world);
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

  /// True if a part is narrow and long. Points on the outside of a leg alone are farther apart than
  /// in a box full of points, so that the extents count.
  bool IsLegShaped(const std::vector<std::size_t>& part) const {
    const Eigen::Vector3d extents_m = PrincipalAxesOf(PointsOf(part)).extents_m;
    return extents_m.y() < parameters_.min_width_voxels * voxel_m_ &&
           extents_m.y() < parameters_.max_leg_share * extents_m.x();
  }

  /// Drops parts that the voxels are too coarse for: what is left of the legs of a table, or noise.
  void DropSlenderParts() {
    const double min_width_m = parameters_.min_width_voxels * voxel_m_;
    std::erase_if(parts_, [&](const std::vector<std::size_t>& part) {
      return PrincipalAxesOf(PointsOf(part)).lengths_m.y() < min_width_m || IsLegShaped(part);
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
  std::vector<double> weights_;          ///< Of the voxels of the points.
  std::vector<ScenePointKind> kinds_;    ///< Of the points.
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
