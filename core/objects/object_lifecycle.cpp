#include "core/objects/object_lifecycle.h"

#include <algorithm>

#include "core/change/belief_update.h"
#include "core/objects/object_merge.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// How often what came lately is compared with what is archived around it.
constexpr std::uint64_t kFramesPerComparison = 8;

/// About, square metres: a point of the surface stands for a side of its voxel.
double SurfaceArea(const TrackedObject& object, const VoxelScale& scale) {
  return static_cast<double>(object.surface().point_count()) * scale.voxel_size_m *
         scale.voxel_size_m;
}

}  // namespace

void ObjectLifecycle::Run(const std::vector<ObjectInView>& in_view, WorkingMap* map) {
  map_ = map;
  for (TrackedObject* object : map_->TentativeObjects()) {
    const ObjectState& state = object->state();
    if (state.supporting_frames >= parameters_.views && Confirm(object)) continue;
    if ((map_->now() - state.last_seen).seconds() > parameters_.max_unseen_s) {
      map_->Delete(object);
    }
  }
  if (parameters_.recognises_returned && map_->revision().value() % kFramesPerComparison == 0) {
    TakeBackParts(in_view);
  }
}

/// Makes a tentative object part of the map; whether it did.
bool ObjectLifecycle::Confirm(TrackedObject* object) {
  if (TakePlace(object)) return true;
  const double seen_m2 =
      static_cast<double>(object->state().supporting_frames) * SurfaceArea(*object, map_->scale());
  if (seen_m2 < static_cast<double>(parameters_.views) * parameters_.min_area_m2) return false;
  const bool is_in_view = object->state().last_seen == map_->now();
  if (is_in_view && object->state().supporting_frames < parameters_.views_beside &&
      IsBesideRecent(*object)) {
    return false;
  }
  Enter(EventType::kCreated, EventReason::kNewSurface, ObjectId(), object);
  return true;
}

/// The same for one that the map has known in some way; whether it has.
bool ObjectLifecycle::TakePlace(TrackedObject* object) {
  if (TrackedObject* known = FindKnown(*object)) {
    TakeBack(known, object);
    return true;
  }
  if (const TrackedObject* whole = FindWholeOf(*object); whole != nullptr) {
    // A wall that was moved along itself shows what it did at first, and may still have moved.
    if (!Stays(*object)) {
      ObjectEdit edit = map_->Edit(object);
      Timestamp& first_seen = edit.state().first_seen;
      first_seen = std::min(first_seen, whole->state().first_seen);
    }
    Enter(EventType::kSplit, EventReason::kDisconnected, whole->id(), object);
    return true;
  }
  if (parameters_.recognises_pieces) {
    const PieceParameters& piece =
        Stays(*object) ? parameters_.recognition.fixture : parameters_.recognition.thing;
    TrackedObject* host = FindHost(*object, piece, ObjectsAround(*object, piece.distance_m));
    if (host != nullptr) {
      MergeObjects(host, object, map_);
      return true;
    }
  }
  return false;
}

/// Whether another thing of its class came close to it lately, of which it may be a part.
bool ObjectLifecycle::IsBesideRecent(const TrackedObject& object) {
  if (!parameters_.recognises_pieces) return false;
  const PieceParameters& piece = parameters_.recognition.thing;
  const std::vector<TrackedObject*> around = ObjectsAround(object, piece.distance_m);
  return std::any_of(around.begin(), around.end(), [&](const TrackedObject* other) {
    return MayBeOneThing(object, *other, piece);
  });
}

void ObjectLifecycle::Enter(EventType type,
                            EventReason reason,
                            ObjectId related,
                            TrackedObject* object) {
  {
    ObjectEdit edit = map_->Edit(object);
    edit.state().status = ObjectStatus::kPresent;
  }
  ObjectEvent event = map_->MakeEvent(type, reason, *object);
  event.related = related;
  map_->RecordEvent(event);
}

/// The objects that may share surface with one, or come as near.
std::vector<TrackedObject*> ObjectLifecycle::ObjectsAround(const TrackedObject& object,
                                                           double distance_m) {
  return map_->ObjectsNear(Grow(object.BoundsInWorld(), distance_m));
}

bool ObjectLifecycle::Stays(const TrackedObject& object) const {
  return PriorOf(config_, object.state().class_id) == StationarityPrior::kStationary;
}

TrackedObject* ObjectLifecycle::FindKnown(const TrackedObject& object) {
  if (!parameters_.recognises_returned) return nullptr;
  return FindReturned(object,
                      map_->scale(),
                      PriorOf(config_, object.state().class_id),
                      parameters_.recognition,
                      ObjectsAround(object, map_->scale().truncation_m));
}

/// What stayed was never looked through.
const TrackedObject* ObjectLifecycle::FindWholeOf(const TrackedObject& object) {
  if (!parameters_.recognises_rests) return nullptr;
  const TrackedObject* whole = FindWhole(object,
                                         map_->scale(),
                                         parameters_.recognition,
                                         ObjectsAround(object, map_->scale().truncation_m));
  return whole == nullptr || IsInFreeSpace(object) ? nullptr : whole;
}

bool ObjectLifecycle::IsInFreeSpace(const TrackedObject& object) const {
  const Eigen::Isometry3d T_world_object = object.state().T_world_object.ToIsometry();
  std::size_t free = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      free += map_->free_space().HasFreeSpaceBehind(
                  T_world_object * point.position_object.cast<double>(),
                  T_world_object.linear() * point.normal_object.cast<double>())
                  ? 1U
                  : 0U;
    }
  }
  return static_cast<double>(free) >
         parameters_.rest_free_share * static_cast<double>(object.surface().point_count());
}

/// Takes what was held for a new object as an archived one that stands again.
void ObjectLifecycle::TakeBack(TrackedObject* known, TrackedObject* object) {
  std::vector<TrackedObject*> others;
  if (Stays(*known)) {
    others = FindGoneWith(*known, parameters_.recognition, map_->ArchivedObjects());
  }
  {
    ObjectEdit edit = map_->Edit(known);
    edit.state().supporting_frames += object->state().supporting_frames;
    CopyVoxels(*object, map_->scale(), &edit);
  }
  Return(known, EventReason::kShapeMatched, object->state().belief);
  if (object->state().status == ObjectStatus::kPresent) {
    TellMerged(*object, EventReason::kShapeMatched, known->id(), map_);
  }
  map_->Delete(object);
  const Belief unseen = InitialBelief(parameters_.initial_stationarity);
  for (TrackedObject* other : others) Return(other, EventReason::kConnected, unseen);
}

/// Takes an archived object as standing in its place again.
void ObjectLifecycle::Return(TrackedObject* object, EventReason reason, const Belief& belief) {
  const Belief before = object->state().belief;
  {
    ObjectEdit edit = map_->Edit(object);
    ObjectState& state = edit.state();
    state.status = ObjectStatus::kPresent;
    state.belief = belief;
    state.evidence = {};
    state.in_place_since = map_->now();
    state.last_seen = map_->now();
  }
  ObjectEvent event = map_->MakeEvent(EventType::kReturned, reason, *object);
  event.before = before;
  map_->RecordEvent(event);
}

/// Gives new objects of classes that stay what was once known of them: a wall is taken down and put
/// up again as a whole, and seldom shown as one.
void ObjectLifecycle::TakeBackParts(const std::vector<ObjectInView>& in_view) {
  for (const ObjectInView& view : in_view) {
    const ObjectState& state = view.object->state();
    const double age_s = (map_->now() - state.in_place_since).seconds();
    if (state.status != ObjectStatus::kPresent || age_s >= parameters_.recent_s ||
        !Stays(*view.object)) {
      continue;
    }
    // What was too little to be known when it came may be enough now. What came back before has a
    // history of its own.
    const bool is_new = state.first_seen == state.in_place_since;
    if (TrackedObject* known = is_new ? FindKnown(*view.object) : nullptr; known != nullptr) {
      TakeBack(known, view.object);
      continue;
    }
    for (TrackedObject* part :
         FindReturnedParts(*view.object,
                           map_->scale(),
                           parameters_.recognition,
                           ObjectsAround(*view.object, map_->scale().truncation_m))) {
      {
        ObjectEdit edit = map_->Edit(view.object);
        CopyVoxels(*part, map_->scale(), &edit);
      }
      TellMerged(*part, EventReason::kShapeMatched, view.object->id(), map_);
      map_->Delete(part);
    }
  }
}

}  // namespace steadymap
