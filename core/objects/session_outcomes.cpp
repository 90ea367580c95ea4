#include "core/objects/session_outcomes.h"

#include <algorithm>
#include <vector>

#include "core/change/surface_looks.h"
#include "core/map/contradiction.h"
#include "core/map/object_evidence.h"
#include "core/map/stationarity.h"
#include "core/objects/session_parts.h"
#include "core/working/object_split.h"

namespace steadymap {

void SessionOutcomes::Create(TrackedObject* object) {
  {
    ObjectEdit edit = map_->Edit(object);
    edit.state().status = ObjectStatus::kPresent;
    edit.state().source = source_;
    edit.state().in_place_since = object->state().first_seen;
  }
  map_->RecordEvent(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
}

void SessionOutcomes::Confirm(TrackedObject* seen, TrackedObject* known) {
  const bool is_back = known->is_archived();
  AddVoxels(*seen, map_, known);
  {
    ObjectEdit edit = map_->Edit(known);
    ObjectState& state = edit.state();
    if (is_back) {
      state.status = ObjectStatus::kPresent;
      state.in_place_since = seen->state().first_seen;
      state.belief = InitialBelief(parameters_.initial_stationarity);
    }
    ReportPresence(source_, seen->state().last_seen, &state);
    state.supporting_frames += seen->state().supporting_frames;
  }
  if (is_back) {
    map_->RecordEvent(map_->MakeEvent(EventType::kReturned, EventReason::kNewSurface, *known));
  } else {
    UpdateBeliefOf(0.0, known);
  }
  map_->Delete(seen);
}

void SessionOutcomes::ConfirmStructure(TrackedObject* structure) {
  if (CountLooks(*structure).found == 0) return;
  UpdateBeliefOf(0.0, structure);
  const Timestamp last_look = LastLookAt(*structure);
  ObjectEdit edit = map_->Edit(structure);
  ReportPresence(source_, last_look, &edit.state());
}

void SessionOutcomes::Join(const ShapeMatch& match, TrackedObject* before, TrackedObject* after) {
  const Eigen::Vector3d old_center_world = before->cuboid().center_world;
  const UprightPose T_world_before = before->state().T_world_object;
  {
    ObjectEdit edit = map_->Edit(after);
    ResampleVoxels(*before, match.T_world_object, 1.0, map_->scale(), &edit);
  }
  const Belief belief_before = before->state().belief;
  {
    ObjectEdit edit = map_->Edit(before);
    edit.TakeVolume(*after);
    ObjectState& state = edit.state();
    state.status = ObjectStatus::kPresent;
    state.evidence = {};  // Of the old place.
    state.looks.clear();
    state.belief = InitialBelief(parameters_.initial_stationarity);
    state.in_place_since = after->state().first_seen;
    state.last_seen = after->state().last_seen;
    state.source = source_;
    state.supporting_frames += after->state().supporting_frames;
  }
  ObjectEvent event = map_->MakeEvent(EventType::kMoved, EventReason::kShapeMatched, *before);
  event.before = belief_before;
  event.old_center_world = old_center_world;
  event.move = {T_world_before, UprightPoseOf(match.T_world_object)};
  event.confidence = match.confidence();
  event.related = after->id();
  map_->RecordEvent(event);
  map_->Delete(after);
}

void SessionOutcomes::Remove(TrackedObject* known, ObjectId part_of) {
  const Belief before = known->state().belief;
  UpdateBeliefOf(parameters_.belief.max_change_m, known);
  ObjectEvent event = map_->MakeEvent(EventType::kRemoved, EventReason::kSeenThrough, *known);
  event.before = before;
  event.related = part_of;
  map_->RecordEvent(event);
  ObjectEdit edit = map_->Edit(known);
  edit.state().status = ObjectStatus::kArchived;
  edit.state().in_place_since = LastLookAt(*known);
  edit.state().looks.clear();
}

bool SessionOutcomes::IsContradicted(TrackedObject* known) {
  const Timestamp last_look = LastLookAt(*known);
  ObjectEdit edit = map_->Edit(known);
  const Contradiction* contradiction =
      ReportAbsence(source_, last_look, parameters_.contradiction_window_s, &edit.state());
  return contradiction != nullptr && contradiction->is_confirmed();
}

void SessionOutcomes::KeepContradicted(TrackedObject* known) {
  const Belief before = known->state().belief;
  UpdateBeliefOf(parameters_.belief.max_change_m, known);
  const std::vector<Contradiction>& all = known->state().contradictions;
  if (std::none_of(all.begin(), all.end(), [&](const Contradiction& contradiction) {
        return contradiction.absent == source_ && contradiction.sessions == kConfirmingSessions;
      })) {
    return;
  }
  ObjectEvent event = map_->MakeEvent(EventType::kContradicted, EventReason::kDisagreement, *known);
  event.before = before;
  event.source = source_;
  map_->RecordEvent(event);
}

void SessionOutcomes::Settle(TrackedObject* object) {
  if (object->state().evidence.leaves.empty() && object->state().parts.empty()) return;
  const LookCount looks = CountLooks(*object);
  ObjectEdit edit = map_->Edit(object);
  ObjectEvidence& evidence = edit.state().evidence;
  evidence = {};
  evidence.present_cells = static_cast<double>(looks.found);
  evidence.absent_cells = static_cast<double>(looks.gone);
  edit.state().parts.clear();
  edit.state().gaps.clear();
}

/// Returns when the session last looked at a known object; without looks, the time of its last
/// frame.
Timestamp SessionOutcomes::LastLookAt(const TrackedObject& known) const {
  const Timestamp last_look = LastLook(known.state().evidence.leaves);
  return last_look > Timestamp() ? last_look : map_->now();
}

void SessionOutcomes::UpdateBeliefOf(double change_m, TrackedObject* object) {
  ObjectEdit edit = map_->Edit(object);
  ObjectState& state = edit.state();
  state.belief = UpdateStationarity(
                     state.belief, change_m, PriorOf(config_, state.class_id), parameters_.belief)
                     .belief;
}

}  // namespace steadymap
