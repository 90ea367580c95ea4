#include "core/objects/changed_regions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/objects/surface_parts.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// Nearer surfaces are not told apart, voxels.
constexpr double kResolvedVoxels = 1.0;

/// What is known of a surface point.
enum class Change { kUnknown, kSame, kChanged };

/// Marks the surface points between voxels that were all observed.
std::vector<char> FindResolved(const TrackedObject& object, const VoxelScale& scale) {
  TsdfSampler sampler(object.volume(), scale);
  std::vector<char> is_resolved;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      is_resolved.push_back(sampler.Sample(point.position_object.cast<double>()).known ? 1 : 0);
    }
  }
  return is_resolved;
}

/// The surface points of an object, with what changed of them.
class ChangedSurface {
 public:
  ChangedSurface(const SessionPartParameters& parameters,
                 const std::vector<Change>& changes,
                 const TrackedObject& object,
                 const VoxelScale& scale)
      : parameters_(parameters),
        voxel_m_(scale.voxel_size_m),
        changes_(changes),
        points_(OrientedSurfaceOf(object)),
        weights_(SurfaceWeightsOf(object)),
        is_resolved_(FindResolved(object, scale)) {}

  /// Returns the part of each point: from 1 on, of a changed region; 0: the rest.
  std::vector<std::size_t> PartOfPoints(std::size_t* part_count) const {
    std::vector<std::pair<std::size_t, std::size_t>> seeds;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (changes_[i] != Change::kUnknown) seeds.emplace_back(i, changes_[i] == Change::kChanged);
    }
    const std::vector<std::size_t> is_changed = SpreadParts(
        points_, seeds, parameters_.surface.contact_voxels * voxel_m_, parameters_.concave_cost_m);
    std::vector<char> is_same(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) is_same[i] = is_changed[i] == 0 ? 1 : 0;
    std::vector<std::size_t> part_of(points_.size(), 0);
    *part_count = 0;
    for (const std::vector<std::size_t>& region :
         FindConnectedParts(points_, is_same, parameters_.scene.near_voxels * voxel_m_)) {
      if (!IsOfThing(region)) continue;
      ++*part_count;
      for (const std::size_t point : region) part_of[point] = *part_count;
    }
    return part_of;
  }

 private:
  /// True if a region is large enough for a thing, and seen well enough. A weight above 1 does not
  /// make up for a small area: more looks do not correct an error of the poses.
  bool IsOfThing(const std::vector<std::size_t>& region) const {
    std::vector<OrientedPoint> surface;
    double changed_weight = 0.0;
    std::size_t resolved = 0;
    for (const std::size_t point : region) {
      surface.push_back(points_[point]);
      changed_weight += changes_[point] == Change::kChanged ? std::min(weights_[point], 1.0) : 0.0;
      resolved += is_resolved_[point] != 0 ? 1 : 0;
    }
    const double changed_m2 = changed_weight * voxel_m_ * voxel_m_;
    return changed_m2 >= parameters_.scene.min_weighted_area_m2 &&
           resolved >= parameters_.min_points &&
           PrincipalAxesOf(surface).lengths_m.y() >= parameters_.scene.min_width_voxels * voxel_m_;
  }

  const SessionPartParameters& parameters_;
  double voxel_m_;
  const std::vector<Change>& changes_;
  std::vector<OrientedPoint> points_;
  std::vector<double> weights_;
  std::vector<char> is_resolved_;
};

/// Divides an object at the border between what changed and what did not.
std::vector<TrackedObject*> SeparateChanged(const SessionPartParameters& parameters,
                                            const std::vector<Change>& changes,
                                            TrackedObject* object,
                                            WorkingMap* map) {
  std::size_t part_count = 0;
  const std::vector<std::size_t> part_of =
      ChangedSurface(parameters, changes, *object, map->scale()).PartOfPoints(&part_count);
  if (part_count == 0) return {};
  return DivideVoxels(object, part_of, part_count, map);
}

/// What was known at a point before the session.
class EarlierMap {
 public:
  EarlierMap(const SessionPartParameters& parameters,
             const TrackedObject& known,
             double same_voxels,
             const WorkingMap& map)
      : parameters_(parameters),
        map_(map),
        voxel_m_(map.scale().voxel_size_m),
        same_m_(same_voxels * voxel_m_),
        T_known_world_(known.state().T_world_object.ToIsometry().inverse()),
        of_known_(known.volume(), map.scale()),
        of_background_(map.background(), map.scale()) {}

  Change Compare(const OrientedPoint& point) {
    const OrientedPoint in_known{T_known_world_ * point.position_world,
                                 T_known_world_.linear() * point.normal_world};
    const Change of_known = CompareWith(&of_known_, in_known);
    const Change of_background = CompareWith(&of_background_, point);
    if (of_known == Change::kSame || of_background == Change::kSame) return Change::kSame;
    if (of_known == Change::kChanged || of_background == Change::kChanged) return Change::kChanged;
    if (IsAtKnownSurface(in_known.position_world)) return Change::kUnknown;
    return WasOpenBehind(point) ? Change::kChanged : Change::kUnknown;
  }

 private:
  Change CompareWith(TsdfSampler* sampler, const OrientedPoint& point) const {
    const DistanceSample sample = sampler->Sample(point.position_world);
    if (!sample.known) return Change::kUnknown;
    if (sample.distance_m > same_m_) return Change::kChanged;
    const bool is_same = sample.distance_m < -same_m_ || sample.gradient.dot(point.normal_world) >=
                                                             parameters_.surface.min_normal_cosine;
    return is_same ? Change::kSame : Change::kUnknown;
  }

  /// True if the known object has surface within a voxel. A face that both sessions saw at flat
  /// angles is one layer of voxels, and the normals of such a layer are noise.
  bool IsAtKnownSurface(const Eigen::Vector3d& point_known) {
    double distance_m = 0.0;
    return of_known_.SampleNearest(point_known, &distance_m) && std::abs(distance_m) <= voxel_m_;
  }

  /// True if the space behind a surface was seen to be open. Where only cells of free space tell,
  /// those around must be free too: at an edge, a cell is partly beside the thing.
  bool WasOpenBehind(const OrientedPoint& point) {
    const Eigen::Vector3d behind_world =
        point.position_world - parameters_.behind_m * point.normal_world;
    const DistanceSample of_known = of_known_.Sample(T_known_world_ * behind_world);
    if (of_known.known) return of_known.distance_m > 0.5 * voxel_m_;
    const DistanceSample of_background = of_background_.Sample(behind_world);
    if (of_background.known) return of_background.distance_m > 0.5 * voxel_m_;
    const FreeSpace& free_space = map_.free_space();
    const Eigen::Vector3d along = free_space.cell_size_m() * point.normal_world.unitOrthogonal();
    const Eigen::Vector3d across = point.normal_world.cross(along);
    return free_space.IsFree(behind_world) && free_space.IsFree(behind_world + along) &&
           free_space.IsFree(behind_world - along) && free_space.IsFree(behind_world + across) &&
           free_space.IsFree(behind_world - across);
  }

  const SessionPartParameters& parameters_;
  const WorkingMap& map_;
  double voxel_m_;
  double same_m_;  ///< Surface that is closer may be the same.
  Eigen::Isometry3d T_known_world_;
  TsdfSampler of_known_;
  TsdfSampler of_background_;
};

/// Tells which surface of an object of the session was not there when a known object and the
/// background were seen. Surface within `same_voxels` of theirs may be the same.
std::vector<Change> FindNewSurface(const SessionPartParameters& parameters,
                                   const TrackedObject& known,
                                   const TrackedObject& seen,
                                   double same_voxels,
                                   const WorkingMap& map) {
  EarlierMap earlier(parameters, known, same_voxels, map);
  std::vector<Change> changes;
  for (const OrientedPoint& point : OrientedSurfaceOf(seen)) {
    changes.push_back(earlier.Compare(point));
  }
  return changes;
}

}  // namespace

std::vector<TrackedObject*> SeparateGoneRegions(const SessionPartParameters& parameters,
                                                TrackedObject* known,
                                                WorkingMap* map) {
  std::vector<Change> changes;
  bool is_any_gone = false;
  for (const SurfaceLeaf& leaf : known->surface().leaves()) {
    const LeafEvidence* evidence = known->state().evidence.FindLeaf(leaf.origin);
    for (const SurfaceVoxel& point : leaf.points) {
      const int score = evidence == nullptr ? 0 : evidence->score[point.cell()];
      changes.push_back(score == 0  ? Change::kUnknown
                        : score > 0 ? Change::kSame
                                    : Change::kChanged);
      is_any_gone = is_any_gone || score < 0;
    }
  }
  if (!is_any_gone) return {};
  return SeparateChanged(parameters, changes, known, map);
}

std::vector<TrackedObject*> SeparateNewRegions(const SessionPartParameters& parameters,
                                               const TrackedObject& known,
                                               TrackedObject* seen,
                                               WorkingMap* map) {
  const std::vector<Change> changes =
      FindNewSurface(parameters, known, *seen, parameters.surface.contact_voxels, *map);
  return SeparateChanged(parameters, changes, seen, map);
}

double NewShareOf(const SessionPartParameters& parameters,
                  const TrackedObject& known,
                  const TrackedObject& seen,
                  const WorkingMap& map) {
  std::size_t changed = 0;
  std::size_t compared = 0;
  for (const Change change : FindNewSurface(parameters, known, seen, kResolvedVoxels, map)) {
    if (change != Change::kUnknown) ++compared;
    if (change == Change::kChanged) ++changed;
  }
  return compared == 0 ? 0.0 : static_cast<double>(changed) / static_cast<double>(compared);
}

}  // namespace steadymap
