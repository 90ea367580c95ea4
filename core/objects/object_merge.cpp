#include "core/objects/object_merge.h"

#include <algorithm>
#include <cmath>

#include "core/association/surface_adjacency.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

bool IsPresent(const TrackedObject& object) {
  return object.state().status == ObjectStatus::kPresent;
}

}  // namespace

void MergeObjects(TrackedObject* into, TrackedObject* from, WorkingMap* map) {
  const ObjectState& other = from->state();
  {
    ObjectEdit edit = map->Edit(into);
    CopyVoxels(*from, map->scale(), &edit);
    ObjectState& state = edit.state();
    state.first_seen = std::min(state.first_seen, other.first_seen);
    state.in_place_since = std::min(state.in_place_since, other.in_place_since);
    state.last_seen = std::max(state.last_seen, other.last_seen);
    state.supporting_frames = std::max(state.supporting_frames, other.supporting_frames);
  }
  if (other.status == ObjectStatus::kPresent) {
    TellMerged(*from, EventReason::kConnected, into->id(), map);
  }
  map->Delete(from);
}

void TellMerged(const TrackedObject& from, EventReason reason, ObjectId into, WorkingMap* map) {
  ObjectEvent event = map->MakeEvent(EventType::kMerged, reason, from);
  event.related = into;
  map->RecordEvent(event);
}

void MergeConnected(const SampleGrid& samples,
                    const Association& association,
                    const std::vector<ObjectInView>& in_view,
                    const MergeParameters& parameters,
                    WorkingMap* map) {
  if (parameters.contacts == 0) return;
  for (const Contact& contact : FindSurfaceAdjacencies(samples, association)) {
    if (contact.samples < parameters.contacts) continue;
    TrackedObject* a = in_view[contact.first - 1].object;
    TrackedObject* b = in_view[contact.second - 1].object;
    const double apart_s = (a->state().in_place_since - b->state().in_place_since).seconds();
    if (a->is_archived() || b->is_archived() || a->state().class_id != b->state().class_id ||
        std::abs(apart_s) > parameters.recent_s || !ShareLattice(a->state(), b->state())) {
      continue;
    }
    const bool keeps_a = IsPresent(*a) == IsPresent(*b) ? a->id() < b->id() : IsPresent(*a);
    MergeObjects(keeps_a ? a : b, keeps_a ? b : a, map);
  }
}

}  // namespace steadymap
