#include "core/objects/gap_division.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <vector>

#include "core/objects/gap_planes.h"
#include "core/objects/surface_parts.h"
#include "core/objects/unsegmented_surface.h"

namespace steadymap {
namespace {

/// The division of the objects of one class in a session.
class GapDivision {
 public:
  GapDivision(const SessionPartParameters& parameters,
              const SensorName& source,
              ClassId class_id,
              WorkingMap* map,
              PartDecisions* decisions)
      : parameters_(parameters),
        source_(source),
        class_id_(class_id),
        map_(map),
        decisions_(decisions) {}

  /// Divides what is beside a gap, if all of it together is divided by the gap.
  void DivideAt(const GapPlane& gap) {
    const std::vector<TrackedObject*> objects = ObjectsOfClass();
    std::vector<TrackedObject*> beside;
    std::vector<OrientedPoint> points;
    for (TrackedObject* object : objects) {
      const std::vector<OrientedPoint> surface = OrientedSurfaceOf(*object);
      if (!IsBeside(gap, surface, map_->scale().voxel_size_m)) continue;
      beside.push_back(object);
      points.insert(points.end(), surface.begin(), surface.end());
    }
    if (!Divides(gap, points, map_->scale().voxel_size_m)) return;
    Sides sides;
    std::vector<const TrackedObject*> divided;
    for (TrackedObject* object : beside) {
      if (Divide(gap, object, &sides)) divided.push_back(object);
    }
    for (TrackedObject* object : objects) {
      if (std::find(beside.begin(), beside.end(), object) != beside.end()) continue;
      if (std::any_of(divided.begin(), divided.end(), [&](const TrackedObject* other) {
            return HaveVotes(*object, *other);
          })) {
        sides.Of(gap.DistanceOf(object->BoundsInWorld().center())).push_back(object);
      }
    }
    Decide(sides);
  }

 private:
  /// The objects on both sides of a gap.
  struct Sides {
    std::vector<TrackedObject*> before;
    std::vector<TrackedObject*> behind;

    std::vector<TrackedObject*>& Of(double distance_m) {
      return distance_m < 0.0 ? before : behind;
    }
  };

  std::vector<TrackedObject*> ObjectsOfClass() const {
    std::vector<TrackedObject*> objects = map_->TentativeObjectsOf(source_);
    std::erase_if(objects, [&](const TrackedObject* object) {
      return object->state().class_id != class_id_ || IsUnsegmented(*object);
    });
    return objects;
  }

  /// Makes a new object of the surface behind a gap. False if all of the surface is on one side.
  bool Divide(const GapPlane& gap, TrackedObject* object, Sides* sides) {
    std::vector<std::size_t> is_behind;
    for (const OrientedPoint& point : OrientedSurfaceOf(*object)) {
      is_behind.push_back(gap.DistanceOf(point.position_world) < 0.0 ? 0 : 1);
    }
    const auto count = std::count(is_behind.begin(), is_behind.end(), std::size_t{1});
    if (count == 0 || count == std::ssize(is_behind)) {
      (count == 0 ? sides->before : sides->behind).push_back(object);
      return false;
    }
    TrackedObject* part = DivideVoxels(object, is_behind, 1, map_).front();
    InheritVotes(*object, part, map_);
    sides->before.push_back(object);
    sides->behind.push_back(part);
    return true;
  }

  void Decide(const Sides& sides) {
    for (const TrackedObject* before : sides.before) {
      for (const TrackedObject* behind : sides.behind) {
        decisions_->insert_or_assign(PairOf(before->id(), behind->id()), false);
      }
    }
    for (const std::vector<TrackedObject*>& side : {sides.before, sides.behind}) {
      for (std::size_t i = 0; i < side.size(); ++i) {
        for (std::size_t j = i + 1; j < side.size(); ++j) {
          if (!BelongTogether(*side[i], *side[j])) continue;
          decisions_->try_emplace(PairOf(side[i]->id(), side[j]->id()), true);
        }
      }
    }
  }

  bool BelongTogether(const TrackedObject& a, const TrackedObject& b) const {
    return AreInContact(a, b, parameters_, map_->scale()) || IsFragmentOf(a, b, parameters_) ||
           IsFragmentOf(b, a, parameters_);
  }

  const SessionPartParameters& parameters_;
  const SensorName& source_;
  ClassId class_id_;
  WorkingMap* map_;
  PartDecisions* decisions_;
};

}  // namespace

PartDecisions DivideAtGaps(const SessionPartParameters& parameters,
                           const SensorName& source,
                           WorkingMap* map) {
  std::map<ClassId, std::vector<SeenGap>> gaps;
  for (const TrackedObject* object : map->TentativeObjectsOf(source)) {
    const ObjectState& state = object->state();
    if (state.class_id == kNoClass) continue;
    MergeGaps(state.gaps, &gaps[state.class_id]);
  }
  PartDecisions decisions;
  for (const auto& [class_id, seen] : gaps) {
    GapDivision division(parameters, source, class_id, map, &decisions);
    for (const GapPlane& gap :
         FindGapPlanes(parameters.scene.gaps, seen, map->scale().voxel_size_m)) {
      division.DivideAt(gap);
    }
  }
  return decisions;
}

}  // namespace steadymap
