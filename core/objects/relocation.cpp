#include "core/objects/relocation.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/objects/shape_match.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// Of a move that nearness alone tells.
constexpr double kConfidenceWithoutShape = 0.5;

/// Sides, the shorter of the base first: yaw may have changed by a quarter turn.
Eigen::Vector3d SidesOf(const Cuboid& cuboid) {
  const auto [shorter, longer] = std::minmax(cuboid.size_m.x(), cuboid.size_m.y());
  return {shorter, longer, cuboid.size_m.z()};
}

bool IsAlike(const Cuboid& a, const Cuboid& b, const RelocationParameters& parameters) {
  const Eigen::Array3d sides_a = SidesOf(a);
  const Eigen::Array3d sides_b = SidesOf(b);
  Eigen::Array3d tolerance_m = (parameters.size_tolerance_share * sides_a.max(sides_b))
                                   .max(parameters.least_size_tolerance_m)
                                   .min(parameters.size_tolerance_m);
  // From one side, nobody knows how deep a thing is.
  tolerance_m.x() = parameters.size_tolerance_m;
  return ((sides_a - sides_b).abs() <= tolerance_m).all();
}

/// Whether two things may be alike as far as they were seen: from one side, nobody knows how deep a
/// thing is.
bool MayBeAlike(const Cuboid& a, const Cuboid& b, double size_tolerance_m) {
  const auto larger_sides = [](const Cuboid& cuboid) {
    Eigen::Vector3d sides = cuboid.size_m;
    std::sort(sides.begin(), sides.end());
    return Eigen::Vector2d(sides.y(), sides.z());
  };
  return (larger_sides(a) - larger_sides(b)).cwiseAbs().maxCoeff() <= size_tolerance_m;
}

double DistanceOfCenters(const TrackedObject& a, const TrackedObject& b) {
  return (a.cuboid().center_world - b.cuboid().center_world).norm();
}

double HeightBetween(const TrackedObject& a, const TrackedObject& b) {
  return std::abs(a.cuboid().center_world.z() - b.cuboid().center_world.z());
}

/// One search through the objects of a map.
class MoveSearch {
 public:
  /// What went no more than `recent_s` before the other thing came went on the same visit.
  MoveSearch(const RelocationParameters& parameters, double recent_s, WorkingMap* map)
      : parameters_(parameters), recent_s_(recent_s), map_(map) {}

  /// The object in view that `after` was pushed aside from; null if none was, or if it may as well
  /// have been another one.
  TrackedObject* FindPushed(const TrackedObject& after,
                            const std::vector<ObjectInView>& in_view) const {
    TrackedObject* nearest = nullptr;
    double nearest_m = parameters_.pushed_distance_m;
    for (const ObjectInView& view : in_view) {
      const ObjectState& old = view.object->state();
      if (old.status != ObjectStatus::kPresent || old.class_id != after.state().class_id ||
          old.evidence.absent_streak_cells < parameters_.pushed_absent_cells ||
          old.in_place_since >= after.state().in_place_since ||
          !IsAlike(view.object->cuboid(), after.cuboid(), parameters_) ||
          HeightBetween(*view.object, after) > parameters_.pushed_height_m ||
          Stands(*view.object, after)) {
        continue;
      }
      const double distance_m = DistanceOfCenters(*view.object, after);
      if (distance_m > nearest_m) continue;
      nearest = view.object;
      nearest_m = distance_m;
    }
    return nearest == nullptr || HasRival(*nearest, nearest_m, after) ? nullptr : nearest;
  }

  /// The archived object that alone looks like `after`; null if none does, or several do. Those
  /// that stand are looked at only if there is one, since most things are new.
  TrackedObject* FindOnlyLookalike(const TrackedObject& after) const {
    TrackedObject* found = nullptr;
    for (TrackedObject* other : map_->ArchivedObjects()) {
      if (other->is_deleted() || !IsLookalike(*other, after)) continue;
      if (found != nullptr) return nullptr;
      found = other;
    }
    if (found == nullptr || !IsAlike(found->cuboid(), after.cuboid(), parameters_)) return nullptr;
    for (const auto& [id, other] : map_->objects()) {
      if (other.state().status == ObjectStatus::kPresent && IsLookalike(other, after)) {
        return nullptr;
      }
    }
    return found;
  }

  /// Whether most of `before`, which stood clear of `after`, was found a moment ago.
  bool Stands(const TrackedObject& before, const TrackedObject& after) const {
    if (DistanceBetween(before.cuboid(), after.cuboid()) <= 0.0) return false;
    const Timestamp lately = map_->now() - Duration::FromSeconds(recent_s_);
    const auto found = static_cast<double>(CountFoundCells(before, lately));
    const auto all = static_cast<double>(CountDoubtedCells(before, 0).all);
    return found > parameters_.pushed_found_share * all;
  }

  bool IsLookalike(const TrackedObject& other, const TrackedObject& after) const {
    return &other != &after && other.state().class_id == after.state().class_id &&
           MayBeAlike(other.cuboid(), after.cuboid(), parameters_.lookalike_tolerance_m);
  }

  /// Whether another thing that is alike, and went on the visit on which `after` came or was not
  /// seen in its place since, stood hardly further off than `before`.
  bool HasRival(const TrackedObject& before, double distance_m, const TrackedObject& after) const {
    const double reach_m = parameters_.rival_distance * distance_m;
    const Eigen::Vector3d margin_m = Eigen::Vector3d::Constant(reach_m);
    const Eigen::Vector3d center_world = after.cuboid().center_world;
    const Timestamp came = after.state().in_place_since;
    for (const TrackedObject* other :
         map_->ObjectsNear({center_world - margin_m, center_world + margin_m})) {
      const ObjectState& state = other->state();
      const bool is_unaccounted =
          other->is_history() ? state.in_place_since > came - Duration::FromSeconds(recent_s_)
                              : state.status == ObjectStatus::kPresent &&
                                    state.in_place_since < came && state.last_seen < came;
      if (other != &before && is_unaccounted && IsLookalike(*other, after) &&
          DistanceOfCenters(*other, after) <= reach_m) {
        return true;
      }
    }
    return false;
  }

  bool Fits(const ShapeMatch& match) const {
    return IsComparable(match) && match.overlap.fit_share >= parameters_.fit_share;
  }

  /// Whether what was pushed aside may have this shape.
  bool MayHaveBeenPushed(const ShapeMatch& match) const {
    return !IsComparable(match) || match.overlap.fit_share >= parameters_.pushed_fit_share;
  }

  /// Makes one object of both ends of a move; the shape before is kept if `match` says where.
  void Join(TrackedObject* before,
            TrackedObject* after,
            EventReason reason,
            const std::optional<ShapeMatch>& match) {
    const Eigen::Vector3d old_center_world = before->cuboid().center_world;
    const UprightPose T_world_before = before->state().T_world_object;
    if (match.has_value()) {
      ObjectEdit edit = map_->Edit(after);
      ResampleVoxels(*before, match->T_world_object, parameters_.kept_weight, map_->scale(), &edit);
    }
    const Belief belief_before = before->state().belief;
    {
      ObjectEdit edit = map_->Edit(before);
      edit.TakeVolume(*after);
      ObjectState& state = edit.state();
      state.status = ObjectStatus::kPresent;
      state.belief = after->state().belief;
      state.evidence = after->state().evidence;
      state.in_place_since = after->state().in_place_since;
      state.last_seen = after->state().last_seen;
      state.supporting_frames += after->state().supporting_frames;
    }
    ObjectEvent event = map_->MakeEvent(EventType::kMoved, reason, *before);
    event.before = belief_before;
    event.old_center_world = old_center_world;
    if (match.has_value()) {
      event.move = {T_world_before, UprightPoseOf(match->T_world_object)};
    }
    event.confidence = match.has_value() ? match->confidence() : kConfidenceWithoutShape;
    event.related = after->id();
    map_->RecordEvent(event);
    map_->Delete(after);
  }

 private:
  bool IsComparable(const ShapeMatch& match) const {
    return match.overlap.known_share >= parameters_.known_share;
  }

  const RelocationParameters& parameters_;
  double recent_s_;
  WorkingMap* map_;
};

}  // namespace

void FindRelocations(const std::vector<ObjectInView>& in_view,
                     double recent_s,
                     const RelocationParameters& parameters,
                     WorkingMap* map) {
  MoveSearch search(parameters, recent_s, map);
  for (const ObjectInView& view : in_view) {
    TrackedObject* after = view.object;
    const ObjectState& state = after->state();
    const double age_s = (map->now() - state.in_place_since).seconds();
    // What came back or was moved before has a history of its own.
    if (state.status != ObjectStatus::kPresent || state.supporting_frames < parameters.views ||
        age_s >= recent_s || state.first_seen != state.in_place_since) {
      continue;
    }
    if (TrackedObject* before = search.FindPushed(*after, in_view); before != nullptr) {
      const ShapeMatch match = MatchShapes(*before, *after, map->scale());
      if (!search.MayHaveBeenPushed(match)) continue;
      search.Join(before,
                  after,
                  EventReason::kDisplaced,
                  search.Fits(match) ? std::optional(match) : std::nullopt);
    } else if (before = search.FindOnlyLookalike(*after); before != nullptr) {
      const ShapeMatch match = MatchShapes(*before, *after, map->scale());
      if (search.Fits(match)) search.Join(before, after, EventReason::kShapeMatched, match);
    }
  }
}

}  // namespace steadymap
