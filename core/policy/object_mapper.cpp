#include "core/policy/object_mapper.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/association/cell_ownership.h"
#include "core/association/class_votes.h"
#include "core/association/ground.h"
#include "core/association/new_object.h"
#include "core/change/free_space_carving.h"
#include "core/types/parallel.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// A view counts when at least so many samples fit.
constexpr std::size_t kMinFittingSamples = 12;

// Objects that a core judges at a time: some 50 us of work.
constexpr std::size_t kMinRangeObjects = 4;

/// What speaks most against an object.
EventReason ReasonOf(const ObjectVerdict& verdict) {
  if (verdict.turned > verdict.seen_through + verdict.replaced) return EventReason::kDisplaced;
  return verdict.replaced > verdict.seen_through ? EventReason::kReplaced
                                                 : EventReason::kSeenThrough;
}

}  // namespace

ObjectMapper::ObjectMapper(const MapConfig& config,
                           const ObjectMapperParameters& parameters,
                           StageObserver* stages)
    : config_(config),
      parameters_(parameters),
      stages_(stages),
      guard_(parameters.guard),
      moving_(config, parameters.moving),
      clusters_(config, parameters.clusters),
      confirmation_(config, parameters.confirmation),
      integrator_(config),
      far_tiles_(config) {}

void ObjectMapper::Process(const Frame& frame, SemanticCloud* cloud, WorkingMap* map) {
  map_ = map;
  cloud_ = cloud;
  stages_.Enter(MapperStage::kGuard);
  moving_.Apply(frame.source, *map, cloud);
  samples_.Compute(*cloud);
  tiles_.Compute(frame.depth);
  far_tiles_.Compute(frame);
  if (!guard_.Accept(frame, {*cloud, samples_, tiles_}, map)) return;
  moving_.Record(frame.source, *cloud, map);
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
  MergeConnected(samples_, association_, in_view_, parameters_.merging, map_);
  confirmation_.Run(in_view_, map_);
  if (parameters_.finds_moves) {
    FindRelocations(in_view_, parameters_.confirmation.recent_s, parameters_.moves, map_);
  }
  stages_.Enter(MapperStage::kFreeSpace);
  if (parameters_.remembers_free_space) {
    CarveFreeSpace(samples_, cloud_->T_world_camera().translation(), map_);
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
      {*cloud_, samples_, tiles_, far_tiles_}, in_view_, association_, parameters_.visibility);
  std::vector<ObjectVerdict> verdicts(in_view_.size());
  ParallelFor(in_view_.size(), kMinRangeObjects, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) verdicts[i] = test.Judge(*in_view_[i].object);
  });
  stages_.Enter(MapperStage::kBelief);
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    if (verdicts[i].judged() == 0) continue;
    if (verdicts[i].turned > 0) ReleaseSamples(static_cast<std::uint32_t>(i + 1), &association_);
    TrackedObject* object = in_view_[i].object;
    {
      ObjectEdit edit = map_->Edit(object);
      AddEvidence(verdicts[i],
                  object->surface(),
                  map_->now(),
                  parameters_.judgement.visit_gap_s,
                  &edit.state().evidence);
    }
    DecideOn(verdicts[i], object);
  }
}

/// Updates the belief in an object, and removes it or what is gone of it.
void ObjectMapper::DecideOn(const ObjectVerdict& verdict, TrackedObject* object) {
  const ObjectState& state = object->state();
  const StationarityPrior prior = PriorOf(config_, state.class_id);
  const Belief before = state.belief;
  {
    ObjectEdit edit = map_->Edit(object);
    if (!UpdateBelief(prior, map_->now(), parameters_.judgement, &edit.state())) return;
  }
  if (state.belief.stationarity() < parameters_.min_stationarity &&
      IsContradicted(verdict, map_->now(), parameters_.contradiction, *object)) {
    Archive(object, ReasonOf(verdict), before);
  } else if (parameters_.cuts_gone_parts) {
    RemoveGoneParts(object);
  }
}

void ObjectMapper::Archive(TrackedObject* object, EventReason reason, const Belief& before) {
  if (object->state().status == ObjectStatus::kPresent) {
    ObjectEvent event = map_->MakeEvent(EventType::kRemoved, reason, *object);
    event.before = before;
    map_->RecordEvent(event);
  }
  BecomeHistory(object);
}

/// Takes an object out of the map.
void ObjectMapper::BecomeHistory(TrackedObject* object) {
  {
    ObjectEdit edit = map_->Edit(object);
    edit.state().status = ObjectStatus::kArchived;
    edit.state().in_place_since = map_->now();
  }
  if (!parameters_.keeps_removed) map_->Delete(object);
}

/// Up to which score cells are to be cut off; none while too few are, or more are on their way.
std::optional<int> ObjectMapper::FindGoneScore(const TrackedObject& object) const {
  const DoubtedCells cells = CountDoubtedCells(object, -parameters_.gone_score);
  if (cells.gone >= parameters_.min_gone_cells) {
    // While more cells are on their way, the part is not known yet.
    return 2 * cells.doubted > 3 * cells.gone ? std::nullopt
                                              : std::optional(-parameters_.gone_score);
  }
  if (cells.gone == 0 || CountDoubtedCells(object, -parameters_.sliver_gone_score).gone == 0) {
    return std::nullopt;
  }
  return -parameters_.sliver_gone_score;
}

/// Cuts off what frames have found gone again and again while the rest of the object stands. What
/// is large enough to have been a thing becomes an archived object of its own.
void ObjectMapper::RemoveGoneParts(TrackedObject* object) {
  const std::optional<int> score = FindGoneScore(*object);
  if (!score.has_value()) return;
  TrackedObject& part = map_->AddPart(*object);
  {
    ObjectEdit edit = map_->Edit(object);
    ObjectEdit part_edit = map_->Edit(&part);
    MoveGoneVoxels({*score, -parameters_.beside_gone_score}, &edit, &part_edit);
  }
  if (object->state().status != ObjectStatus::kPresent ||
      CountConnectedCells(part) < parameters_.min_part_cells) {
    map_->Delete(&part);
    return;
  }
  BecomeHistory(&part);
  ObjectEvent split = map_->MakeEvent(EventType::kSplit, EventReason::kDisconnected, part);
  split.related = object->id();
  map_->RecordEvent(split);
  map_->RecordEvent(map_->MakeEvent(EventType::kRemoved, EventReason::kSeenThrough, part));
}

void ObjectMapper::PlaceObservations() {
  for (const Observation& observation : observations_) {
    const std::uint32_t owner = ChooseOwner(observation);
    if (owner == Association::kNone) continue;
    for (const std::size_t index : observation.samples) association_.owner[index] = owner;
  }
}

bool ObjectMapper::IsRecent(const ObjectState& state) const {
  return (map_->now() - state.in_place_since).seconds() < parameters_.confirmation.recent_s;
}

bool ObjectMapper::IsInFreeSpace(const Observation& observation) const {
  const auto free =
      std::count_if(observation.samples.begin(), observation.samples.end(), [&](std::size_t index) {
        const SurfaceSample& sample = samples_[index];
        return association_.is_in_front[index] != 0 ||
               map_->free_space().HasFreeSpaceBehind(sample.position_world.cast<double>(),
                                                     sample.normal_world.cast<double>());
      });
  return static_cast<double>(free) >
         parameters_.confirmation.free_share * static_cast<double>(observation.samples.size());
}

/// Whether surface with a label of the background is of a thing: on its edge, or in the middle of
/// it. It would stay in the background when the thing goes.
bool ObjectMapper::IsMislabelled(const Observation& observation) const {
  if (observation.contacts.empty()) return observation.area_m2 < parameters_.min_seen_area_m2;
  const double max_area_m2 = observation.TouchesBackground() ? parameters_.confirmation.min_area_m2
                                                             : parameters_.max_mislabelled_area_m2;
  return observation.TouchesObject() && observation.area_m2 < max_area_m2;
}

std::uint32_t ObjectMapper::ChooseOwner(const Observation& observation) {
  const bool is_whole = observation.instance != 0;
  const bool is_small = observation.area_m2 < parameters_.confirmation.min_area_m2;
  const bool is_tiny = observation.area_m2 < parameters_.min_seen_area_m2;
  if (!is_whole && config_.IsInBackground(ClassId(observation.label))) {
    return IsMislabelled(observation) ? Association::kNone : kBackgroundOwner;
  }
  const bool is_free = IsInFreeSpace(observation);
  std::uint32_t same_class = Association::kNone;
  for (const BorderContact& contact : observation.contacts) {
    if (contact.owner == kBackgroundOwner) continue;
    const ObjectState& state = in_view_[contact.owner - 1].object->state();
    if (state.status == ObjectStatus::kArchived) continue;
    const bool is_of_its_class = state.class_id.value() == observation.label;
    if (is_of_its_class && same_class == Association::kNone) same_class = contact.owner;
    if (is_free && !IsRecent(state)) continue;
    if (is_of_its_class || (is_small && !is_whole)) return contact.owner;
  }
  if (!is_tiny) return AddObject(observation);
  // Too little to be a thing: a leg or an edge, around which all is free.
  return is_whole ? Association::kNone : same_class;
}

std::uint32_t ObjectMapper::AddObject(const Observation& observation) {
  TrackedObject& object = AddObjectOf(observation, samples_, map_);
  ObjectEdit edit = map_->Edit(&object);
  edit.state().belief = InitialBelief(parameters_.confirmation.initial_stationarity);
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
    ObjectEdit edit = map_->Edit(in_view_[i].object);
    ObjectState& state = edit.state();
    ++state.supporting_frames;
    if (state.status == ObjectStatus::kTentative) state.last_seen = map_->now();
    AddVotes(samples_by_class[i], &state);
  }
}

void ObjectMapper::Integrate() {
  integrator_.SetFrame(*cloud_);
  map_->FuseBackground(&integrator_);
  for (std::size_t i = 0; i < in_view_.size(); ++i) {
    TrackedObject* object = in_view_[i].object;
    if (fitting_samples_[i] == 0 || object->is_archived()) continue;
    map_->FuseObject(static_cast<std::uint32_t>(i + 1), object, &integrator_);
  }
}

}  // namespace steadymap
