#include "core/recognition.h"

#include <algorithm>
#include <cmath>

#include "core/object_parts.h"
#include "core/tsdf_sample.h"

namespace steadymap {
namespace {

constexpr double kMinNormalCosine = 0.5;

Eigen::Isometry3d RelativePose(const TrackedObject& object, const TrackedObject& other) {
  return other.state().T_world_object.ToIsometry().inverse() *
         object.state().T_world_object.ToIsometry();
}

/// Whether `known` is archived, of the class of `object`, and stood where that stands.
bool IsArchivedNear(const TrackedObject& known, const TrackedObject& object) {
  if (!known.is_history() || known.state().class_id != object.state().class_id ||
      !ShareLattice(known.state(), object.state())) {
    return false;
  }
  const Eigen::Vector3d shift_m = RelativePose(object, known).translation();
  Box bounds_known = object.bounds_object();
  bounds_known.translate(shift_m);
  return bounds_known.intersects(known.bounds_object());
}

/// Compares two objects where they stand, or stood.
SurfaceOverlap CompareInPlace(const TrackedObject& object,
                              const TrackedObject& other,
                              const VoxelScale& scale) {
  return CompareSurfaces(object, other, RelativePose(object, other), scale);
}

}  // namespace

SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const VoxelScale& scale) {
  // Pose error and noise of two looks at one surface.
  const double tolerance_m = 1.5 * scale.voxel_size_m;
  const std::size_t points = object.surface().point_count();
  if (points == 0) return {};
  TsdfSampler sampler(other.volume(), scale);
  std::size_t known = 0;
  std::size_t fitting = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3d position = T_other_object * point.position_object.cast<double>();
      double distance_m = 0.0;
      const bool is_inner = sampler.SampleDistance(position, &distance_m);
      if (!is_inner && !sampler.SampleNearest(position, &distance_m)) continue;
      ++known;
      if (std::abs(distance_m) > tolerance_m) continue;
      const Eigen::Vector3d normal = T_other_object.linear() * point.normal_object.cast<double>();
      if (is_inner && sampler.Sample(position).gradient.dot(normal) < kMinNormalCosine) continue;
      ++fitting;
    }
  }
  if (known == 0) return {};
  return {static_cast<double>(known) / static_cast<double>(points),
          static_cast<double>(fitting) / static_cast<double>(known)};
}

TrackedObject* FindReturned(const TrackedObject& object,
                            const VoxelScale& scale,
                            StationarityPrior prior,
                            const RecognitionParameters& parameters,
                            const std::vector<TrackedObject*>& candidates) {
  const double known_share = prior == StationarityPrior::kStays
                                 ? parameters.return_known_share_of_walls
                                 : parameters.return_known_share;
  TrackedObject* best = nullptr;
  double best_share = 0.0;
  for (TrackedObject* known : candidates) {
    if (!IsArchivedNear(*known, object)) continue;
    const SurfaceOverlap overlap = CompareInPlace(object, *known, scale);
    const double share = overlap.known_share * overlap.fit_share;
    if (overlap.known_share < known_share || overlap.fit_share < parameters.return_fit_share ||
        share < best_share) {
      continue;
    }
    best_share = share;
    best = known;
  }
  return best;
}

std::vector<TrackedObject*> FindGoneWith(const TrackedObject& object,
                                         const RecognitionParameters& parameters,
                                         const std::vector<TrackedObject*>& candidates) {
  const ObjectState& first = object.state();
  std::vector<TrackedObject*> gone;
  std::vector<const TrackedObject*> reached = {&object};
  for (std::size_t next = 0; next < reached.size(); ++next) {
    const Cuboid& cuboid = reached[next]->cuboid();
    for (TrackedObject* other : candidates) {
      const ObjectState& state = other->state();
      const double apart_s = state.standing_since.seconds() - first.standing_since.seconds();
      if (!other->is_history() || state.class_id != first.class_id ||
          std::abs(apart_s) > parameters.same_visit_s ||
          std::find(reached.begin(), reached.end(), other) != reached.end() ||
          DistanceBetween(cuboid, other->cuboid()) > parameters.neighbour_distance_m) {
        continue;
      }
      reached.push_back(other);
      gone.push_back(other);
    }
  }
  return gone;
}

std::vector<TrackedObject*> FindReturnedParts(const TrackedObject& object,
                                              const VoxelScale& scale,
                                              const RecognitionParameters& parameters,
                                              const std::vector<TrackedObject*>& candidates) {
  std::vector<TrackedObject*> parts;
  for (TrackedObject* known : candidates) {
    if (!IsArchivedNear(*known, object)) continue;
    const SurfaceOverlap overlap = CompareInPlace(*known, object, scale);
    if (overlap.known_share >= parameters.part_known_share &&
        overlap.fit_share >= parameters.return_fit_share) {
      parts.push_back(known);
    }
  }
  return parts;
}

}  // namespace steadymap
