#include "core/object_mapper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/cell_ownership.h"
#include "core/class_votes.h"
#include "core/contact.h"
#include "core/free_rays.h"
#include "core/ground.h"
#include "core/new_object.h"
#include "core/object_parts.h"
#include "core/recognition.h"

namespace steadymap {
namespace {

// A view counts when at least so many samples fit.
constexpr std::size_t kMinFittingSamples = 12;

// How often new objects are compared with what is archived around them.
constexpr std::uint64_t kFramesPerComparison = 8;

// Free space this deep inside a surface was free before the surface came.
constexpr float kInsideM = 0.08F;

/// What speaks most against an object.
EventReason ReasonOf(const ObjectVerdict& verdict) {
  if (verdict.turned > verdict.seen_through + verdict.replaced) return EventReason::kDisplaced;
  return verdict.replaced > verdict.seen_through ? EventReason::kReplaced
                                                 : EventReason::kSeenThrough;
}

/// About, square metres: a point of the surface stands for a side of its voxel.
double SurfaceArea(const TrackedObject& object, const VoxelScale& scale) {
  return static_cast<double>(object.surface().point_count()) * scale.voxel_size_m *
         scale.voxel_size_m;
}

}  // namespace

ObjectMapper::ObjectMapper(const MapConfig& config,
                           const ObjectMapperParameters& parameters,
                           StageObserver* stages)
    : config_(config),
      parameters_(parameters),
      stages_(stages),
      guard_(parameters.guard),
      clusters_(config, parameters.clusters),
      integrator_(config) {}

void ObjectMapper::Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  cloud_ = cloud;
  stages_.Enter(MapperStage::kGuard);
  samples_.Compute(*cloud);
  tiles_.Compute(frame.depth);
  if (!guard_.Admit(frame, {*cloud, samples_, tiles_}, map)) return;
  FindOwners();
  JudgeObjects();
  stages_.Enter(MapperStage::kObservations);
  observations_ = FindObservations(samples_, association_);
  PlaceObservations();
  CountViews();
  GiveCellsToOwners(samples_, association_, cloud_);
  stages_.Enter(MapperStage::kIntegration);
  Integrate();
  stages_.Enter(MapperStage::kObjects);
  MergeConnected();
  ConfirmAndForget();
  TakeBackParts();
  if (parameters_.finds_moves) {
    FindMoves(in_view_, parameters_.recent_s, parameters_.moves, map_);
  }
  stages_.Enter(MapperStage::kFreeSpace);
  if (parameters_.remembers_free_space) {
    MarkFreeRays(samples_, cloud_->T_world_camera().translation(), map_);
  }
}

void ObjectMapper::FindOwners() {
  stages_.Enter(MapperStage::kAssociation);
  const double max_range_m = parameters_.visibility.max_depth_m;
  in_view_ = FindObjectsInView(
      map_->ObjectsNear(ReachOfView(*cloud_, max_range_m)), *cloud_, samples_, max_range_m);
  const double camera_height_m = cloud_->T_world_camera().translation().z();
  clusters_.Compute(samples_, camera_height_m);
  AssociateSamples(samples_, in_view_, map_->background(), map_->scale(), clusters_, &association_);
  clusters_.MatchOneToOne(in_view_, &association_);
  stages_.Enter(MapperStage::kGround);
  if (const std::optional<double> ground = FindGroundHeight(samples_, camera_height_m)) {
    AssignGround(samples_, *ground, &association_);
  }
}

void ObjectMapper::JudgeObjects() {
  stages_.Enter(MapperStage::kVisibility);
  const VisibilityTest test(
      *cloud_, samples_, tiles_, in_view_, association_, parameters_.visibility);
  std::vector<ObjectVerdict> verdicts;
  verdicts.reserve(in_view_.size());
  for (const ObjectInView& view : in_view_) verdicts.push_back(test.Judge(*view.object));
  stages_.Enter(MapperStage::kBelief);
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    if (verdicts[i].judged() == 0) continue;
    if (verdicts[i].turned > 0) ReleaseSamples(static_cast<std::uint32_t>(i + 1), &association_);
    TrackedObject* object = in_view_[i].object;
    AddEvidence(verdicts[i], object->surface(), map_->now(), &object->state().evidence);
    map_->MarkChanged(object);
    DecideOn(verdicts[i], object);
  }
}

/// Updates the belief in an object, and removes it or what is gone of it.
void ObjectMapper::DecideOn(const ObjectVerdict& verdict, TrackedObject* object) {
  ObjectState& state = object->state();
  const StationarityPrior prior = PriorOf(config_, state.class_id);
  const Belief before = state.belief;
  if (!UpdateBelief(prior, map_->now(), parameters_.judgement, &state)) return;
  if (state.belief.stationarity() < parameters_.min_stationarity) {
    Archive(object, ReasonOf(verdict), before);
  } else if (parameters_.cuts_gone_parts) {
    RemoveGoneParts(object);
  }
}

void ObjectMapper::Archive(TrackedObject* object, EventReason reason, const Belief& before) {
  if (object->state().standing == ObjectStanding::kPresent) {
    ObjectEvent event = map_->MakeEvent(EventType::kRemoved, reason, *object);
    event.before = before;
    map_->Tell(event);
  }
  BecomeHistory(object);
}

/// Takes an object out of the map.
void ObjectMapper::BecomeHistory(TrackedObject* object) {
  object->state().standing = ObjectStanding::kArchived;
  object->state().standing_since = map_->now();
  map_->MarkChanged(object);
  if (!parameters_.keeps_removed) map_->Forget(object);
}

/// Cuts off what frames have found gone again and again while the rest of the object stands. The
/// part becomes an archived object of its own.
void ObjectMapper::RemoveGoneParts(TrackedObject* object) {
  const auto [gone, doubted] = CountDoubtedCells(*object, -parameters_.gone_score);
  // While more cells are on their way, the part is not known yet.
  if (gone < parameters_.min_gone_cells || 2 * doubted > 3 * gone) return;
  TrackedObject& part = map_->AddPart(*object);
  BecomeHistory(&part);
  const std::vector<LeafOrigin> moved = MoveGoneVoxels(-parameters_.gone_score, object, &part);
  map_->MarkLeaves(object, moved);
  map_->MarkLeaves(&part, moved);
  if (object->state().standing != ObjectStanding::kPresent ||
      gone < parameters_.min_reported_cells) {
    return;
  }
  ObjectEvent split = map_->MakeEvent(EventType::kSplit, EventReason::kDisconnected, *object);
  split.related = part.id();
  map_->Tell(split);
  map_->Tell(map_->MakeEvent(EventType::kRemoved, EventReason::kSeenThrough, part));
}

void ObjectMapper::PlaceObservations() {
  for (const Observation& observation : observations_) {
    const std::uint32_t owner = ChooseOwner(observation);
    if (owner == Association::kNone) continue;
    for (const std::size_t index : observation.samples) association_.owner[index] = owner;
  }
}

bool ObjectMapper::IsRecent(const ObjectState& state) const {
  return map_->now().seconds() - state.standing_since.seconds() < parameters_.recent_s;
}

/// Makes one of objects whose surfaces were found connected on one visit.
void ObjectMapper::MergeConnected() {
  if (parameters_.merging_contacts == 0) return;
  for (const Contact& contact : FindContacts(samples_, association_)) {
    if (contact.samples < parameters_.merging_contacts) continue;
    TrackedObject* a = in_view_[contact.first - 1].object;
    TrackedObject* b = in_view_[contact.second - 1].object;
    const double apart_s =
        a->state().standing_since.seconds() - b->state().standing_since.seconds();
    if (a->is_archived() || b->is_archived() || a->state().class_id != b->state().class_id ||
        std::abs(apart_s) > parameters_.recent_s || !ShareLattice(a->state(), b->state())) {
      continue;
    }
    const bool a_is_older = a->id() < b->id();
    Merge(a_is_older ? a : b, a_is_older ? b : a);
  }
}

void ObjectMapper::Merge(TrackedObject* into, TrackedObject* from) {
  ObjectState& state = into->state();
  ObjectState& other = from->state();
  const MovedLeaves moved = CopyVoxels(*from, map_->scale(), into);
  map_->MarkLeaves(into, moved.into);
  state.first_seen = std::min(state.first_seen, other.first_seen);
  state.standing_since = std::min(state.standing_since, other.standing_since);
  state.last_seen = std::max(state.last_seen, other.last_seen);
  state.views = std::max(state.views, other.views);
  if (other.standing == ObjectStanding::kPresent) {
    TellMerged(*from, EventReason::kConnected, state.id);
  }
  map_->MarkChanged(into);
  map_->Forget(from);
}

bool ObjectMapper::IsInFreeSpace(const Observation& observation) const {
  std::size_t free = 0;
  for (const std::size_t index : observation.samples) {
    const SurfaceSample& sample = samples_[index];
    const Eigen::Vector3f inside_world = sample.position_world - kInsideM * sample.normal_world;
    if (association_.is_in_front[index] != 0 ||
        map_->free_space().IsFree(inside_world.cast<double>())) {
      ++free;
    }
  }
  return static_cast<double>(free) >
         parameters_.free_share * static_cast<double>(observation.samples.size());
}

std::uint32_t ObjectMapper::ChooseOwner(const Observation& observation) {
  const bool is_small = observation.area_m2 < parameters_.min_new_area_m2;
  if (observation.instance == 0 && config_.IsInBackground(ClassId(observation.label))) {
    // A wrong label on the edge of a thing would stay in the background when the thing goes.
    return is_small && observation.TouchesObject() ? Association::kNone : kBackgroundOwner;
  }
  const bool is_free = IsInFreeSpace(observation);
  for (const BorderContact& contact : observation.contacts) {
    if (contact.owner == kBackgroundOwner) continue;
    const ObjectState& state = in_view_[contact.owner - 1].object->state();
    if (state.standing == ObjectStanding::kArchived) continue;
    if (is_free && !IsRecent(state)) continue;
    const bool is_one_thing = is_small && observation.instance == 0;
    if (is_one_thing || state.class_id.value() == observation.label) return contact.owner;
  }
  if (observation.area_m2 < parameters_.min_seen_area_m2) return Association::kNone;
  return AddObject(observation);
}

std::uint32_t ObjectMapper::AddObject(const Observation& observation) {
  TrackedObject& object = AddObjectOf(observation, samples_, map_);
  object.state().belief = InitialBelief(parameters_.initial_stationarity);
  in_view_.push_back({&object, 0, samples_.width(), 0, samples_.height()});
  return static_cast<std::uint32_t>(in_view_.size());
}

/// Counts the frame for the objects it shows, with a vote on their class.
void ObjectMapper::CountViews() {
  fitting_samples_.assign(in_view_.size(), 0);
  std::vector<std::map<ClassId, std::size_t>> samples_by_class(in_view_.size());
  for (std::size_t index = 0; index < samples_.size(); ++index) {
    const std::uint32_t owner = association_.owner[index];
    if (!samples_[index].is_valid() || !Association::IsObject(owner)) continue;
    ++fitting_samples_[owner - 1];
    const std::uint16_t label = samples_[index].label;
    if (!config_.IsInBackground(ClassId(label))) ++samples_by_class[owner - 1][ClassId(label)];
  }
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    if (fitting_samples_[i] < kMinFittingSamples) continue;
    TrackedObject* object = in_view_[i].object;
    ObjectState& state = object->state();
    ++state.views;
    if (state.standing == ObjectStanding::kTentative) state.last_seen = map_->now();
    AddVotes(samples_by_class[i], &state);
    map_->MarkChanged(object);
  }
}

void ObjectMapper::Integrate() {
  map_->FuseBackground(*cloud_, &integrator_);
  const CellRange everywhere{0, cloud_->cells_wide(), 0, cloud_->cells_high()};
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    TrackedObject* object = in_view_[i].object;
    if (fitting_samples_[i] == 0 || object->is_archived()) continue;
    map_->FuseObject(
        *cloud_, {static_cast<std::uint32_t>(i + 1), everywhere}, object, &integrator_);
  }
}

void ObjectMapper::ConfirmAndForget() {
  for (TrackedObject* object : map_->TentativeObjects()) {
    const ObjectState& state = object->state();
    if (state.views >= parameters_.confirming_views && Confirm(object)) continue;
    if (map_->now().seconds() - state.last_seen.seconds() > parameters_.tentative_age_s) {
      map_->Forget(object);
    }
  }
}

/// Makes a tentative object part of the map, as an old one that is back or as a new one; whether it
/// did. A new one that shows little must be seen longer.
bool ObjectMapper::Confirm(TrackedObject* object) {
  if (TrackedObject* known = FindKnown(*object)) {
    TakeBack(known, object);
    return true;
  }
  const double seen_m2 =
      static_cast<double>(object->state().views) * SurfaceArea(*object, map_->scale());
  if (seen_m2 < static_cast<double>(parameters_.confirming_views) * parameters_.min_new_area_m2) {
    return false;
  }
  object->state().standing = ObjectStanding::kPresent;
  map_->Tell(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
  map_->MarkChanged(object);
  return true;
}

/// The objects that may share surface with one.
std::vector<TrackedObject*> ObjectMapper::ObjectsAround(const TrackedObject& object) {
  const Box bounds_world = object.BoundsInWorld();
  const Eigen::Vector3d margin_m = Eigen::Vector3d::Constant(map_->scale().truncation_m);
  return map_->ObjectsNear(Box(bounds_world.min() - margin_m, bounds_world.max() + margin_m));
}

TrackedObject* ObjectMapper::FindKnown(const TrackedObject& object) {
  if (!parameters_.recognises_returned) return nullptr;
  return FindReturned(object,
                      map_->scale(),
                      PriorOf(config_, object.state().class_id),
                      parameters_.recognition,
                      ObjectsAround(object));
}

/// Takes what was held for a new object as an archived one that stands again.
void ObjectMapper::TakeBack(TrackedObject* known, TrackedObject* object) {
  std::vector<TrackedObject*> others;
  if (PriorOf(config_, known->state().class_id) == StationarityPrior::kStays) {
    others = FindGoneWith(*known, parameters_.recognition, map_->ArchivedObjects());
  }
  known->state().views += object->state().views;
  map_->MarkLeaves(known, CopyVoxels(*object, map_->scale(), known).into);
  Return(known, EventReason::kShapeMatched, object->state().belief);
  if (object->state().standing == ObjectStanding::kPresent) {
    TellMerged(*object, EventReason::kShapeMatched, known->id());
  }
  map_->Forget(object);
  const Belief unseen = InitialBelief(parameters_.initial_stationarity);
  for (TrackedObject* other : others) Return(other, EventReason::kConnected, unseen);
}

void ObjectMapper::TellMerged(const TrackedObject& from, EventReason reason, ObjectId into) {
  ObjectEvent event = map_->MakeEvent(EventType::kMerged, reason, from);
  event.related = into;
  map_->Tell(event);
}

/// Takes an archived object as standing in its place again.
void ObjectMapper::Return(TrackedObject* object, EventReason reason, const Belief& belief) {
  ObjectState& state = object->state();
  const Belief before = state.belief;
  state.standing = ObjectStanding::kPresent;
  state.belief = belief;
  state.evidence = {};
  state.standing_since = map_->now();
  state.last_seen = map_->now();
  ObjectEvent event = map_->MakeEvent(EventType::kReturned, reason, *object);
  event.before = before;
  map_->Tell(event);
  map_->MarkChanged(object);
}

/// Gives new objects of classes that stay what was once known of them: a wall is taken down and put
/// up again as a whole, and seldom shown as one.
void ObjectMapper::TakeBackParts() {
  if (!parameters_.recognises_returned || map_->revision().value() % kFramesPerComparison != 0) {
    return;
  }
  for (const ObjectInView& view : in_view_) {
    const ObjectState& state = view.object->state();
    if (state.standing != ObjectStanding::kPresent || !IsRecent(state) ||
        PriorOf(config_, state.class_id) != StationarityPrior::kStays) {
      continue;
    }
    // What was too little to be known when it came may be enough now. What came back before has a
    // history of its own.
    const bool is_new = state.first_seen == state.standing_since;
    if (TrackedObject* known = is_new ? FindKnown(*view.object) : nullptr; known != nullptr) {
      TakeBack(known, view.object);
      continue;
    }
    for (TrackedObject* part : FindReturnedParts(
             *view.object, map_->scale(), parameters_.recognition, ObjectsAround(*view.object))) {
      map_->MarkLeaves(view.object, CopyVoxels(*part, map_->scale(), view.object).into);
      TellMerged(*part, EventReason::kShapeMatched, view.object->id());
      map_->Forget(part);
    }
  }
}

}  // namespace steadymap
