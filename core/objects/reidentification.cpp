#include "core/objects/reidentification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/volume/tsdf_sample.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

constexpr double kMinMatchingCosine = 0.5;

// Pose error and noise of two looks at one surface, in voxels.
constexpr double kFitVoxels = 1.5;

Eigen::Isometry3d RelativePose(const TrackedObject& object, const TrackedObject& other) {
  return other.state().T_world_object.ToIsometry().inverse() *
         object.state().T_world_object.ToIsometry();
}

/// Whether `known` is archived, of the class of `object`, and stood where that stands.
bool IsArchivedNear(const TrackedObject& known,
                    const TrackedObject& object,
                    const VoxelScale& scale) {
  if (!known.is_history() || known.state().class_id != object.state().class_id ||
      !ShareLattice(known.state(), object.state())) {
    return false;
  }
  const Eigen::Vector3d shift_m = RelativePose(object, known).translation();
  Box bounds_known = object.bounds_object();
  if (bounds_known.isEmpty()) return false;
  bounds_known.translate(shift_m);
  // Two looks at the front of a wall are two thin boxes that need not meet.
  return Grow(bounds_known, kFitVoxels * scale.voxel_size_m).intersects(known.bounds_object());
}

/// Whether `known` was found gone long before `object` was seen first.
bool WasGoneForLong(const TrackedObject& known,
                    const TrackedObject& object,
                    const ReidentificationParameters& parameters) {
  return (object.state().in_place_since - known.state().in_place_since).seconds() >
         parameters.wall_absence_s;
}

/// Points of a surface, counted by how they lie with another object.
struct OverlapCounts {
  std::size_t points = 0;
  std::size_t known = 0;    ///< Of those, in what the other has observed.
  std::size_t fitting = 0;  ///< Of those, on its surface, facing the same way.
  YawChangeSum turn;        ///< Of those that fit.
};

/// Counts the points of `object`, moved by `T_other_object`, for which `counts(leaf, point)` holds.
template <typename Counts>
OverlapCounts CountOverlap(const TrackedObject& object,
                           const TrackedObject& other,
                           const Eigen::Isometry3d& T_other_object,
                           const VoxelScale& scale,
                           Counts counts) {
  const double tolerance_m = kFitVoxels * scale.voxel_size_m;
  TsdfSampler sampler(other.volume(), scale);
  OverlapCounts overlap;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      if (!counts(leaf, point)) continue;
      ++overlap.points;
      const Eigen::Vector3d position = T_other_object * point.position_object.cast<double>();
      double distance_m = 0.0;
      const bool is_inner = sampler.SampleDistance(position, &distance_m);
      if (!is_inner && !sampler.SampleNearest(position, &distance_m)) continue;
      ++overlap.known;
      if (std::abs(distance_m) > tolerance_m) continue;
      const Eigen::Vector3d normal = T_other_object.linear() * point.normal_object.cast<double>();
      if (is_inner) {
        const Eigen::Vector3d gradient = sampler.Sample(position).gradient;
        if (gradient.dot(normal) < kMinMatchingCosine) continue;
        overlap.turn.Add(position - distance_m * gradient, gradient, distance_m);
      }
      ++overlap.fitting;
    }
  }
  return overlap;
}

/// Whether `known` was found gone on the visit that `object` is seen on.
bool WentOnVisit(const TrackedObject& known,
                 const TrackedObject& object,
                 const ReidentificationParameters& parameters) {
  return (object.state().last_seen - known.state().in_place_since).seconds() <
         parameters.same_visit_s;
}

/// Whether `known` was found gone on the visit that `object` is seen on, and too little of what was
/// missed of it is there again.
bool StaysGone(const TrackedObject& known,
               const TrackedObject& object,
               const VoxelScale& scale,
               const ReidentificationParameters& parameters) {
  if (!WentOnVisit(known, object, parameters)) return false;
  const OverlapCounts missed =
      CountOverlap(known,
                   object,
                   RelativePose(known, object),
                   scale,
                   [&](const SurfaceLeaf& leaf, const SurfaceVoxel& point) {
                     const LeafEvidence* evidence = known.state().evidence.FindLeaf(leaf.origin);
                     return evidence != nullptr && evidence->score[point.cell] < 0;
                   });
  return static_cast<double>(missed.fitting) <
         parameters.refound_share * static_cast<double>(missed.points);
}

/// The second longest side of an object's cuboid, metres.
double SecondSide(const TrackedObject& object) {
  Eigen::Vector3d sides_m = object.cuboid().size_m;
  std::sort(sides_m.begin(), sides_m.end());
  return sides_m.y();
}

/// Compares two objects where they stand, or stood.
SurfaceOverlap CompareInPlace(const TrackedObject& object,
                              const TrackedObject& other,
                              const VoxelScale& scale) {
  return CompareSurfaces(object, other, RelativePose(object, other), scale);
}

/// Least shares of `SurfaceOverlap`.
struct MinOverlap {
  double known_share = 0.0;
  double fit_share = 0.0;
};

/// The archived candidate whose surface best explains `object` where it stood itself, of those that
/// reach what `ask(candidate)` says of them, if it says anything, and are not turned; null if none
/// does. Of equals the last.
template <typename Ask>
TrackedObject* FindBestOverlap(const TrackedObject& object,
                               const VoxelScale& scale,
                               const YawChangeParameters& turn,
                               const std::vector<TrackedObject*>& candidates,
                               Ask ask) {
  TrackedObject* best = nullptr;
  double best_share = 0.0;
  for (TrackedObject* known : candidates) {
    if (!IsArchivedNear(*known, object, scale)) continue;
    const std::optional<MinOverlap> least = ask(*known);
    if (!least.has_value()) continue;
    const SurfaceOverlap overlap = CompareInPlace(object, *known, scale);
    const double share = overlap.known_share * overlap.fit_share;
    if (overlap.known_share < least->known_share || overlap.fit_share < least->fit_share ||
        overlap.turn.Exceeds(turn) || share < best_share) {
      continue;
    }
    best_share = share;
    best = known;
  }
  return best;
}

}  // namespace

SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const VoxelScale& scale) {
  const OverlapCounts overlap = CountOverlap(
      object, other, T_other_object, scale, [](const SurfaceLeaf&, const SurfaceVoxel&) {
        return true;
      });
  if (overlap.known == 0) return {};
  const auto known = static_cast<double>(overlap.known);
  return {known / static_cast<double>(overlap.points),
          static_cast<double>(overlap.fitting) / known,
          overlap.turn};
}

TrackedObject* FindReturned(const TrackedObject& object,
                            const VoxelScale& scale,
                            StationarityPrior prior,
                            const ReidentificationParameters& parameters,
                            const std::vector<TrackedObject*>& candidates) {
  return FindBestOverlap(
      object,
      scale,
      parameters.turn,
      candidates,
      [&](const TrackedObject& known) -> std::optional<MinOverlap> {
        if (StaysGone(known, object, scale, parameters)) return std::nullopt;
        if (prior == StationarityPrior::kStationary && WasGoneForLong(known, object, parameters)) {
          return MinOverlap{parameters.return_known_share_of_walls,
                            parameters.return_fit_share_of_walls};
        }
        return MinOverlap{parameters.return_known_share, parameters.return_fit_share};
      });
}

TrackedObject* FindWhole(const TrackedObject& object,
                         const VoxelScale& scale,
                         const ReidentificationParameters& parameters,
                         const std::vector<TrackedObject*>& candidates) {
  return FindBestOverlap(
      object,
      scale,
      parameters.turn,
      candidates,
      [&](const TrackedObject& known) -> std::optional<MinOverlap> {
        if (!WentOnVisit(known, object, parameters)) return std::nullopt;
        return MinOverlap{parameters.stayed_known_share, parameters.return_fit_share};
      });
}

bool MayBeOneThing(const TrackedObject& object,
                   const TrackedObject& other,
                   const PieceParameters& parameters) {
  const ObjectState& state = other.state();
  const double apart_s = (object.state().in_place_since - state.in_place_since).seconds();
  return &other != &object && state.status == ObjectStatus::kPresent &&
         state.class_id == object.state().class_id && apart_s <= parameters.apart_s &&
         ShareLattice(state, object.state()) &&
         DistanceBetween(object.cuboid(), other.cuboid()) <= parameters.distance_m;
}

TrackedObject* FindHost(const TrackedObject& object,
                        const PieceParameters& parameters,
                        const std::vector<TrackedObject*>& candidates) {
  if (SecondSide(object) > parameters.size_m) return nullptr;
  TrackedObject* host = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (TrackedObject* other : candidates) {
    if (!MayBeOneThing(object, *other, parameters) || SecondSide(*other) <= parameters.size_m) {
      continue;
    }
    const double distance_m = DistanceBetween(object.cuboid(), other->cuboid());
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    host = other;
  }
  return host;
}

std::vector<TrackedObject*> FindGoneWith(const TrackedObject& object,
                                         const ReidentificationParameters& parameters,
                                         const std::vector<TrackedObject*>& candidates) {
  const ObjectState& first = object.state();
  std::vector<TrackedObject*> gone;
  std::vector<const TrackedObject*> reached = {&object};
  for (std::size_t next = 0; next < reached.size(); ++next) {
    const Cuboid& cuboid = reached[next]->cuboid();
    for (TrackedObject* other : candidates) {
      const ObjectState& state = other->state();
      const double apart_s = (state.in_place_since - first.in_place_since).seconds();
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
                                              const ReidentificationParameters& parameters,
                                              const std::vector<TrackedObject*>& candidates) {
  std::vector<TrackedObject*> parts;
  for (TrackedObject* known : candidates) {
    if (!IsArchivedNear(*known, object, scale)) continue;
    const SurfaceOverlap overlap = CompareInPlace(*known, object, scale);
    const double fit_share = WasGoneForLong(*known, object, parameters)
                                 ? parameters.return_fit_share_of_walls
                                 : parameters.return_fit_share;
    if (overlap.known_share >= parameters.part_known_share && overlap.fit_share >= fit_share &&
        !overlap.turn.Exceeds(parameters.turn)) {
      parts.push_back(known);
    }
  }
  return parts;
}

}  // namespace steadymap
