#include "core/objects/session_identity.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/change/surface_looks.h"
#include "core/geometry/assignment.h"
#include "core/map/contradiction.h"
#include "core/objects/changed_regions.h"
#include "core/objects/session_alignment.h"
#include "core/objects/session_parts.h"
#include "core/objects/shape_match.h"
#include "core/objects/standing.h"
#include "core/objects/surface_relations.h"
#include "core/registration/registration.h"
#include "core/types/parallel.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// Standard deviation of a normal distribution, in medians of its magnitude.
constexpr double kSigmasOfMedian = 1.4826;

// How much more likely a push is than a move from elsewhere, in margins between rivals.
constexpr double kPushMargins = 2.0;

// A motion below this share of a voxel is lost in its interpolation.
constexpr double kNegligibleMotionVoxels = 0.1;

struct KnownObject {
  TrackedObject* object = nullptr;
  std::size_t index = 0;
  Standing standing = Standing::kUnknown;
  bool is_taken = false;  ///< By an object of the session.
};

/// An object of the session.
struct SeenObject {
  TrackedObject* object = nullptr;
  std::size_t index = 0;
  bool is_new_region = false;  ///< Was not there when a known object beside it was seen.
  bool is_decided = false;
};

/// An object of the session on the surface of a known one.
struct PlaceMatch {
  SeenObject* seen = nullptr;
  KnownObject* known = nullptr;
  double displacement_m = 0.0;
  double fit = 0.0;           ///< Share of the surface that agrees.
  bool fits_at_rest = false;  ///< Agrees as well without the displacement.
};

/// An object of the session that has the shape of a known one.
struct MoveCandidate {
  SeenObject* seen = nullptr;
  KnownObject* known = nullptr;
  ShapeMatch match;
  double distance_m = 0.0;  ///< Between both places.
};

/// The decision on one session.
class SessionDecision {
 public:
  SessionDecision(const MapConfig& config,
                  const SessionIdentityParameters& parameters,
                  const SensorName& source,
                  const Eigen::Isometry3d& prior,
                  WorkingMap* map)
      : config_(config), parameters_(parameters), source_(source), map_(map), motion_(prior) {}

  std::optional<PoseOffset> Run() {
    TakeSessionLooks();
    CompleteSessionObjects(parameters_.parts, source_, map_);
    EndVanished();
    for (TrackedObject* object : map_->TentativeObjectsOf(source_)) CutGoneCells(object, map_);
    ListObjects();
    Align();
    SeparateNew();
    MatchInPlace();
    JudgeKnown();
    SeparateGone();
    AddRestsToStructures();
    FindMoves();
    MatchDoubted();
    AddRest();
    EndGone();
    for (TrackedObject* object : map_->AllObjects()) {
      if (object->state().status != ObjectStatus::kTentative) Settle(object);
    }
    return offset_;
  }

 private:
  Timestamp LastLookAt(const TrackedObject& known) const;
  void TakeSessionLooks();
  void Settle(TrackedObject* object);
  void ListObjects();
  void AddSeen(TrackedObject* object, bool is_new_region);
  void AddKnown(TrackedObject* object, Standing standing);
  void SeparateNew();
  void SeparateNewOn(KnownObject* structure, SeenObject* seen);
  void SeparateGone();
  void AddRestsToStructures();
  void ConfirmStructure(TrackedObject* object);
  void Align();
  void Move(const Eigen::Isometry3d& motion, TrackedObject* object);
  double InPlaceLimit(const std::vector<PlaceMatch>& matches, const SeenObject& seen) const;
  std::vector<PlaceMatch> FindPlaceMatches();
  void MatchInPlace();
  double DoubtOf(const TrackedObject& known) const;
  void MatchDoubted();
  double DoubtedFitOf(const SeenObject& seen, const KnownObject& known) const;
  bool IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const;
  bool IsPushed(const KnownObject& known, const ShapeMatch& match) const;
  void Confirm(SeenObject* seen, KnownObject* known);
  void JudgeKnown();
  bool IsContradicted(TrackedObject* object);
  void EndVanished();
  static bool IsOlderThanRemoval(const SeenObject& seen, const KnownObject& known);
  bool MayHaveMoved(const SeenObject& seen, const KnownObject& known) const;
  bool AreOfOneSize(const TrackedObject& seen, const TrackedObject& known) const;
  std::vector<MoveCandidate> ListMoves();
  void DropPushed(const std::vector<MoveCandidate>& candidates);
  double LikelihoodOf(const MoveCandidate& candidate) const;
  std::vector<MoveCandidate> FindClearMoves(const std::vector<MoveCandidate>& candidates) const;
  void FindMoves();
  void Join(TrackedObject* before, TrackedObject* after, const ShapeMatch& match);
  void Create(TrackedObject* object);
  void AddRest();
  bool IsPartOfStanding(const TrackedObject& seen);
  void EndGone();
  void CutGoneParts(TrackedObject* object);
  void UpdateBeliefOf(double change_m, TrackedObject* object);

  const MapConfig& config_;
  const SessionIdentityParameters& parameters_;
  const SensorName& source_;
  WorkingMap* map_;
  std::deque<SeenObject> seen_;  ///< Not moved in memory when it grows.
  std::deque<KnownObject> known_;
  std::vector<std::pair<SeenObject*, KnownObject*>> rests_;  ///< Parts of structures.
  std::optional<PoseOffset> offset_;                         ///< Of the poses of the session.
  Eigen::Isometry3d motion_;                                 ///< Of the session onto the map.
  std::vector<PlaceMatch> doubted_;  ///< In place, but much of the known object is gone.
};

/// Returns when the session last looked at a known object. The time of the map is that of another
/// robot's frame, if such a frame came last.
Timestamp SessionDecision::LastLookAt(const TrackedObject& known) const {
  const Timestamp last_look = LastLook(known.state().evidence.leaves);
  return last_look > Timestamp() ? last_look : map_->now();
}

/// Makes the looks of the session the evidence for each known object. Looks from before another
/// session saw the object in place are out of date.
void SessionDecision::TakeSessionLooks() {
  for (TrackedObject* object : map_->AllObjects()) {
    if (object->state().looks.empty()) continue;
    ObjectEdit edit = map_->Edit(object);
    ObjectState& state = edit.state();
    for (const LeafEvidence& leaf : TakeLooks(source_, &state.looks)) {
      if (leaf.last_look >= state.last_seen) state.evidence.MutableLeaf(leaf.origin) = leaf;
    }
  }
}

/// Makes known objects of those that were seen and then found gone in the same session.
void SessionDecision::EndVanished() {
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    const LookCount looks = CountLooks(*object);
    if (looks.looked_at() < parameters_.min_looked_at_cells ||
        static_cast<double>(looks.gone) <
            parameters_.gone_share * static_cast<double>(looks.looked_at())) {
      continue;
    }
    Create(object);
  }
}

/// Adds an object of the session to the map.
void SessionDecision::Create(TrackedObject* object) {
  {
    ObjectEdit edit = map_->Edit(object);
    edit.state().status = ObjectStatus::kPresent;
    edit.state().source = source_;
    edit.state().in_place_since = object->state().first_seen;
  }
  map_->RecordEvent(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
}

/// Keeps the sums of the evidence of the session.
void SessionDecision::Settle(TrackedObject* object) {
  if (object->state().evidence.leaves.empty() && object->state().parts.empty()) return;
  const LookCount looks = CountLooks(*object);
  ObjectEdit edit = map_->Edit(object);
  ObjectEvidence& evidence = edit.state().evidence;
  evidence = {};
  evidence.present_cells = static_cast<double>(looks.found);
  evidence.absent_cells = static_cast<double>(looks.gone);
  edit.state().parts.clear();
}

void SessionDecision::ListObjects() {
  for (TrackedObject* object : map_->AllObjects()) {
    if (object->is_deleted()) continue;
    if (IsInSession(object->state(), source_)) {
      AddSeen(object, /*is_new_region=*/false);
    } else if (object->state().status != ObjectStatus::kTentative) {
      AddKnown(object, Standing::kUnknown);
    }
  }
}

void SessionDecision::AddSeen(TrackedObject* object, bool is_new_region) {
  seen_.push_back({object, seen_.size(), is_new_region});
}

void SessionDecision::AddKnown(TrackedObject* object, Standing standing) {
  known_.push_back({object, known_.size(), standing});
}

/// Corrects the offset of the session by the objects that stand where they stood.
void SessionDecision::Align() {
  std::vector<const TrackedObject*> seen_objects;
  for (const SeenObject& seen : seen_) seen_objects.push_back(seen.object);
  std::vector<const TrackedObject*> known_objects;
  for (const KnownObject& known : known_) {
    if (!known.object->is_archived()) known_objects.push_back(known.object);
  }
  offset_ = AlignSession(seen_objects, known_objects, motion_, parameters_, map_->scale());
  if (offset_) motion_ = offset_->ToIsometry();
  for (const SeenObject& seen : seen_) Move(motion_, seen.object);
}

void SessionDecision::Move(const Eigen::Isometry3d& motion, TrackedObject* object) {
  const Eigen::Vector3d center_world = object->BoundsInWorld().center();
  const double displacement_m = (motion * center_world - center_world).norm();
  if (displacement_m < kNegligibleMotionVoxels * map_->scale().voxel_size_m) return;
  ObjectEdit edit = map_->Edit(object);
  edit.state().T_world_object = UprightPoseOf(motion * object->state().T_world_object.ToIsometry());
}

bool SessionDecision::IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const {
  return std::any_of(doubted_.begin(), doubted_.end(), [&](const PlaceMatch& match) {
    return match.seen == &seen && match.known == &known;
  });
}

/// Returns the displacement up to which an object of the session stands where it stood: most things
/// do, so that the displacements of the others tell the error of the poses.
double SessionDecision::InPlaceLimit(const std::vector<PlaceMatch>& matches,
                                     const SeenObject& seen) const {
  std::map<const SeenObject*, double> least_m;
  for (const PlaceMatch& match : matches) {
    if (match.seen == &seen || match.known->object->is_archived() ||
        IsFragmentOf(*match.seen->object, *match.known->object, parameters_.parts)) {
      continue;
    }
    const auto [entry, is_new] = least_m.emplace(match.seen, match.displacement_m);
    if (!is_new) entry->second = std::min(entry->second, match.displacement_m);
  }
  if (least_m.empty()) return parameters_.max_displacement_m;
  std::vector<double> others_m;
  others_m.reserve(least_m.size());
  for (const auto& [other, displacement_m] : least_m) others_m.push_back(displacement_m);
  const auto middle = others_m.begin() + static_cast<std::ptrdiff_t>((others_m.size() - 1) / 2);
  std::nth_element(others_m.begin(), middle, others_m.end());
  return std::clamp(parameters_.max_pose_sigmas * kSigmasOfMedian * *middle,
                    parameters_.max_displacement_m,
                    parameters_.max_session_offset_m);
}

/// Returns the known objects that each object of the session may be, in place or almost.
std::vector<PlaceMatch> SessionDecision::FindPlaceMatches() {
  std::vector<PlaceMatch> matches;
  for (SeenObject& seen : seen_) {
    if (seen.is_decided) continue;
    for (KnownObject& known : known_) {
      const std::optional<Registration> registration =
          RegisterToKnown(*seen.object, *known.object, map_->scale());
      if (!registration || registration->dissimilarity > parameters_.max_dissimilarity) continue;
      const double displacement_m = DisplacementOf(*registration, *seen.object);
      // Less of its shape need be known of what is just where it stood.
      const bool is_back = known.object->is_archived();
      const double least_known = is_back && displacement_m > parameters_.max_displacement_m
                                     ? parameters_.min_shape_known_share
                                     : parameters_.min_known_share;
      if (registration->known_share < least_known) continue;
      const double fit = registration->known_share * (1.0 - registration->dissimilarity);
      matches.push_back(
          {&seen, &known, displacement_m, fit, FitsAtRest(*registration, parameters_)});
    }
  }
  // What stands there is more likely than what left.
  std::stable_sort(matches.begin(), matches.end(), [](const PlaceMatch& a, const PlaceMatch& b) {
    if (a.known->object->is_archived() != b.known->object->is_archived()) {
      return b.known->object->is_archived();
    }
    return a.fit > b.fit;
  });
  return matches;
}

void SessionDecision::MatchInPlace() {
  const std::vector<PlaceMatch> matches = FindPlaceMatches();
  for (const PlaceMatch& match : matches) {
    if (match.seen->is_decided) continue;
    const bool is_archived = match.known->object->is_archived();
    const double doubt =
        std::max(DoubtOf(*match.known->object),
                 is_archived ? 0.0 : NewShareOf(*match.known->object, *match.seen->object, *map_));
    const double displacement_m =
        match.fits_at_rest && doubt < parameters_.doubted_share ? 0.0 : match.displacement_m;
    if (IsOlderThanRemoval(*match.seen, *match.known)) {
      // Another session has found it gone since.
      if (displacement_m > InPlaceLimit(matches, *match.seen)) continue;
      match.seen->is_decided = true;
      map_->Delete(match.seen->object);
      continue;
    }
    // What was gone is back where it stood, if not to the centimetre.
    if (!is_archived && displacement_m > InPlaceLimit(matches, *match.seen)) continue;
    const bool is_displaced = displacement_m > parameters_.max_displacement_m;
    if (doubt >= (is_displaced ? parameters_.gone_share : 1.0 - parameters_.doubted_share)) {
      continue;
    }
    if (doubt >= (is_displaced ? parameters_.doubted_share : parameters_.gone_share)) {
      doubted_.push_back(match);
    } else {
      Confirm(match.seen, match.known);
    }
  }
}

/// Returns the share of the looked-at surface that is gone; 0 if the looks were from wrong poses.
double SessionDecision::DoubtOf(const TrackedObject& known) const {
  const Eigen::Vector3d& center_world = known.cuboid().center_world;
  const double displacement_m = (motion_ * center_world - center_world).norm();
  return displacement_m > parameters_.max_displacement_m ? 0.0 : GoneShareOf(known);
}

/// Confirms the doubted matches in place that no move explains better.
void SessionDecision::MatchDoubted() {
  for (const PlaceMatch& match : doubted_) {
    if (!match.seen->is_decided && !match.known->is_taken) Confirm(match.seen, match.known);
  }
}

/// Returns how well an object of the session, or a known object, agrees with standing in place
/// despite what is gone, in [0, 1].
double SessionDecision::DoubtedFitOf(const SeenObject& seen, const KnownObject& known) const {
  double best = 0.0;
  for (const PlaceMatch& match : doubted_) {
    if (match.seen->is_decided || match.known->is_taken) continue;
    if (match.seen != &seen && match.known != &known) continue;
    best = std::max(best, match.fit * (1.0 - DoubtOf(*match.known->object)));
  }
  return best;
}

void SessionDecision::Confirm(SeenObject* seen, KnownObject* known) {
  TrackedObject* object = known->object;
  seen->is_decided = true;
  known->standing = Standing::kStands;
  known->is_taken = true;
  const bool is_back = object->is_archived();
  if (object->state().class_id == kNoClass && !is_back) {
    for (TrackedObject* region :
         SeparateNewRegions(parameters_.parts, *object, seen->object, map_)) {
      AddSeen(region, /*is_new_region=*/true);
    }
  }
  AddVoxels(*seen->object, map_, object);
  {
    ObjectEdit edit = map_->Edit(object);
    ObjectState& state = edit.state();
    if (is_back) {
      state.status = ObjectStatus::kPresent;
      state.in_place_since = seen->object->state().first_seen;
      state.belief = InitialBelief(parameters_.initial_stationarity);
    }
    ReportPresence(source_, seen->object->state().last_seen, &state);
    state.supporting_frames += seen->object->state().supporting_frames;
  }
  if (is_back) {
    map_->RecordEvent(map_->MakeEvent(EventType::kReturned, EventReason::kNewSurface, *object));
  } else {
    UpdateBeliefOf(0.0, object);
  }
  map_->Delete(seen->object);
}

void SessionDecision::UpdateBeliefOf(double change_m, TrackedObject* object) {
  ObjectEdit edit = map_->Edit(object);
  ObjectState& state = edit.state();
  state.belief = UpdateStationarity(
                     state.belief, change_m, PriorOf(config_, state.class_id), parameters_.belief)
                     .belief;
}

void SessionDecision::JudgeKnown() {
  for (KnownObject& known : known_) {
    if (known.standing != Standing::kUnknown || known.object->is_archived()) continue;
    std::vector<const TrackedObject*> others;
    const bool is_structure = IsStructure(*known.object, parameters_.parts.scene);
    for (const SeenObject& seen : seen_) {
      // A thing on a structure does not replace it.
      if (!seen.is_decided && !is_structure && IsOfOneClass(*seen.object, *known.object)) {
        others.push_back(seen.object);
      }
    }
    known.standing = JudgeStanding(*known.object, others, parameters_, map_->scale());
    if (known.standing == Standing::kGone && IsContradicted(known.object)) {
      known.standing = Standing::kContradicted;
    }
  }
}

/// Takes in that the session found a known object gone. True if another sensor insists that it
/// stands: then it stays, and the contradiction is told once.
bool SessionDecision::IsContradicted(TrackedObject* object) {
  const Timestamp last_look = LastLookAt(*object);
  std::uint32_t sessions = 0;
  {
    ObjectEdit edit = map_->Edit(object);
    const Contradiction* contradiction =
        ReportAbsence(source_, last_look, parameters_.contradiction_window_s, &edit.state());
    if (contradiction == nullptr || !contradiction->is_confirmed()) return false;
    sessions = contradiction->sessions;
  }
  const Belief before = object->state().belief;
  UpdateBeliefOf(parameters_.belief.max_change_m, object);
  if (sessions > kConfirmingSessions) return true;
  ObjectEvent event =
      map_->MakeEvent(EventType::kContradicted, EventReason::kDisagreement, *object);
  event.before = before;
  event.source = source_;
  map_->RecordEvent(event);
  return true;
}

/// Separates what is new on structures from what had not been seen of them.
void SessionDecision::SeparateNew() {
  for (KnownObject& known : known_) {
    if (!IsStructure(*known.object, parameters_.parts.scene)) continue;
    const std::size_t count = seen_.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (seen_[i].object->state().class_id != kNoClass || seen_[i].is_decided) continue;
      SeparateNewOn(&known, &seen_[i]);
    }
  }
}

/// Separates what is new in an object of the session on a structure. The rest, in contact with the
/// structure, is a part of it.
void SessionDecision::SeparateNewOn(KnownObject* structure, SeenObject* seen) {
  if (seen->is_new_region) return;
  for (TrackedObject* region :
       SeparateNewRegions(parameters_.parts, *structure->object, seen->object, map_)) {
    AddSeen(region, /*is_new_region=*/true);
  }
  const double contact_m = parameters_.parts.contact_voxels * map_->scale().voxel_size_m;
  const bool is_rest = seen->object->surface().point_count() > 0;
  if (is_rest && !AreInContact(*seen->object, *structure->object, contact_m, map_->scale())) return;
  seen->is_decided = true;
  if (is_rest) {
    rests_.emplace_back(seen, structure);
  } else {
    map_->Delete(seen->object);
  }
}

/// Ends the regions of standing objects without a label that are gone.
void SessionDecision::SeparateGone() {
  const std::size_t count = known_.size();
  for (std::size_t i = 0; i < count; ++i) {
    TrackedObject* object = known_[i].object;
    if (known_[i].standing != Standing::kStands || object->is_archived() ||
        object->state().class_id != kNoClass) {
      continue;
    }
    if (IsStructure(*object, parameters_.parts.scene)) ConfirmStructure(object);
    for (TrackedObject* region : SeparateGoneRegions(parameters_.parts, object, map_)) {
      AddKnown(region, Standing::kGone);
    }
  }
}

/// Adds what structures were not known to have. What is gone of them has been separated.
void SessionDecision::AddRestsToStructures() {
  for (const auto& [seen, known] : rests_) {
    if (known->standing != Standing::kStands) {
      seen->is_decided = false;
      continue;
    }
    AddVoxels(*seen->object, map_, known->object);
    map_->Delete(seen->object);
  }
}

/// Keeps that a structure, of which a session fuses only what is not known, was seen again.
void SessionDecision::ConfirmStructure(TrackedObject* object) {
  if (CountLooks(*object).found == 0) return;
  UpdateBeliefOf(0.0, object);
  const Timestamp last_look = LastLookAt(*object);
  ObjectEdit edit = map_->Edit(object);
  ReportPresence(source_, last_look, &edit.state());
}

/// True if an object of the session that may be a known one in place rather is that one at a new
/// place: all surface that was known is there.
bool SessionDecision::IsPushed(const KnownObject& known, const ShapeMatch& match) const {
  const Eigen::Isometry3d T_object_world =
      known.object->state().T_world_object.ToIsometry().inverse();
  const Eigen::Vector3d center_world = known.object->cuboid().center_world;
  const Eigen::Vector3d moved_world = match.T_world_object * (T_object_world * center_world);
  const SurfaceOverlap self = CompareSurfaces(
      *known.object, *known.object, T_object_world * match.T_world_object, map_->scale());
  if ((moved_world - center_world).norm() <= parameters_.max_displacement_m &&
      self.known_share * self.fit_share >= 1.0 - parameters_.max_dissimilarity) {
    return false;
  }
  const SurfaceOverlap& overlap = match.reverse_overlap;
  return overlap.known_share * overlap.fit_share >= 1.0 - parameters_.max_dissimilarity;
}

/// True if an object of the session was last seen before a known one was removed.
bool SessionDecision::IsOlderThanRemoval(const SeenObject& seen, const KnownObject& known) {
  return known.object->is_archived() &&
         seen.object->state().last_seen < known.object->state().in_place_since;
}

/// True if a known object is not where it was, or if it was pushed to where an object of the
/// session hides its place.
bool SessionDecision::MayHaveMoved(const SeenObject& seen, const KnownObject& known) const {
  if (known.object->is_archived()) return !IsOlderThanRemoval(seen, known);
  if (known.standing == Standing::kGone) return true;
  return known.standing == Standing::kUnverified &&
         DistanceBetween(known.object->cuboid(), seen.object->cuboid()) <= 0.0;
}

/// True if the surfaces of two objects are large enough to be of one.
bool SessionDecision::AreOfOneSize(const TrackedObject& seen, const TrackedObject& known) const {
  return seen.SurfaceAreaM2() >= parameters_.min_moved_area_share * known.SurfaceAreaM2() &&
         known.SurfaceAreaM2() >= parameters_.min_shape_known_share * seen.SurfaceAreaM2();
}

/// Returns the known objects that each undecided object of the session may be, at a new place.
std::vector<MoveCandidate> SessionDecision::ListMoves() {
  std::vector<MoveCandidate> candidates;
  for (SeenObject& seen : seen_) {
    if (seen.is_decided) continue;
    for (KnownObject& known : known_) {
      if (known.is_taken || !IsOfOneClass(*seen.object, *known.object) ||
          !MayHaveMoved(seen, known) || !AreOfOneSize(*seen.object, *known.object)) {
        continue;
      }
      const double distance_m = DistanceBetween(known.object->cuboid(), seen.object->cuboid());
      candidates.push_back({&seen, &known, {}, distance_m});
    }
  }
  // The cuboids, which are computed at the first use, are known from here on.
  ParallelFor(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      MoveCandidate& candidate = candidates[i];
      candidate.match =
          MatchShapes(*candidate.known->object, *candidate.seen->object, map_->scale());
    }
  });
  std::erase_if(candidates, [&](const MoveCandidate& candidate) {
    return candidate.match.overlap.known_share < parameters_.min_shape_known_share ||
           candidate.match.fit_share() < parameters_.min_shape_fit_share ||
           (IsDoubtedMatch(*candidate.seen, *candidate.known) &&
            !IsPushed(*candidate.known, candidate.match));
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.match.confidence() > b.match.confidence();
  });
  return candidates;
}

/// Gives up matches in place that a push explains better, also if several objects may be pushed.
void SessionDecision::DropPushed(const std::vector<MoveCandidate>& candidates) {
  std::erase_if(doubted_, [&](const PlaceMatch& doubted) {
    return std::any_of(candidates.begin(), candidates.end(), [&](const MoveCandidate& candidate) {
      return doubted.seen == candidate.seen && doubted.known == candidate.known &&
             doubted.fit * (1.0 - DoubtOf(*doubted.known->object)) < candidate.match.confidence();
    });
  });
}

/// Returns how likely a move is, on the scale of `rival_margin`. What is not known of a shape does
/// not tell it from another one. Of two equal shapes, the one whose place overlaps was pushed.
double SessionDecision::LikelihoodOf(const MoveCandidate& candidate) const {
  const bool is_pushed = candidate.distance_m <= 0.0 && IsPushed(*candidate.known, candidate.match);
  return candidate.match.fit_share() + (is_pushed ? kPushMargins * parameters_.rival_margin : 0.0);
}

/// Returns the moves without which the best explanation of all changes would be clearly worse.
std::vector<MoveCandidate> SessionDecision::FindClearMoves(
    const std::vector<MoveCandidate>& candidates) const {
  std::vector<AssignmentPair> pairs;
  pairs.reserve(candidates.size());
  for (const MoveCandidate& candidate : candidates) {
    pairs.push_back({candidate.seen->index, candidate.known->index, -LikelihoodOf(candidate)});
  }
  const std::vector<std::optional<std::size_t>> columns =
      AssignClearColumns(seen_.size(), known_.size(), pairs, 0.0, parameters_.rival_margin);
  std::vector<MoveCandidate> clear;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (columns[pairs[i].row] == pairs[i].column) clear.push_back(candidates[i]);
  }
  return clear;
}

/// Joins objects of the session with the gone or archived objects whose shape they have.
void SessionDecision::FindMoves() {
  std::vector<MoveCandidate> candidates = ListMoves();
  DropPushed(candidates);
  std::erase_if(candidates, [&](const MoveCandidate& candidate) {
    return DoubtedFitOf(*candidate.seen, *candidate.known) >= candidate.match.confidence();
  });
  for (const MoveCandidate& candidate : FindClearMoves(candidates)) {
    Join(candidate.known->object, candidate.seen->object, candidate.match);
    candidate.seen->is_decided = true;
    candidate.known->standing = Standing::kStands;
    candidate.known->is_taken = true;
  }
}

/// Makes one object of both ends of a move. It keeps the identity and the history of the first one.
void SessionDecision::Join(TrackedObject* before, TrackedObject* after, const ShapeMatch& match) {
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

/// True if an object of the session continues a standing object, which then has its surface.
bool SessionDecision::IsPartOfStanding(const TrackedObject& seen) {
  const double contact_m = parameters_.parts.contact_voxels * map_->scale().voxel_size_m;
  for (const KnownObject& known : known_) {
    if (known.standing != Standing::kStands || !IsOfOneClass(seen, *known.object)) continue;
    if (!IsFragmentOf(seen, *known.object, parameters_.parts) &&
        !IsThinPartOf(seen, *known.object, parameters_.parts, *map_) &&
        !AreInContact(seen, *known.object, contact_m, map_->scale())) {
      continue;
    }
    // What hides a surface that was seen was not there then.
    if (HiddenShare(*known.object, seen, map_->scale()) >= parameters_.max_overlap_share) continue;
    AddVoxels(seen, map_, known.object);
    return true;
  }
  return false;
}

void SessionDecision::AddRest() {
  for (SeenObject& seen : seen_) {
    if (seen.is_decided) continue;
    if (!seen.is_new_region && IsPartOfStanding(*seen.object)) {
      map_->Delete(seen.object);
      continue;
    }
    Create(seen.object);
  }
}

void SessionDecision::EndGone() {
  for (const KnownObject& known : known_) {
    if (known.object->is_archived()) continue;
    if (known.standing == Standing::kStands) CutGoneParts(known.object);
    if (known.standing != Standing::kGone) continue;
    const Belief before = known.object->state().belief;
    UpdateBeliefOf(parameters_.belief.max_change_m, known.object);
    ObjectEvent event =
        map_->MakeEvent(EventType::kRemoved, EventReason::kSeenThrough, *known.object);
    event.before = before;
    map_->RecordEvent(event);
    ObjectEdit edit = map_->Edit(known.object);
    edit.state().status = ObjectStatus::kArchived;
    edit.state().in_place_since = LastLookAt(*known.object);
    edit.state().looks.clear();
  }
}

/// Takes the surface that is gone off an object that stands.
void SessionDecision::CutGoneParts(TrackedObject* object) {
  const LookCount looks = CountLooks(*object);
  if (looks.gone < parameters_.min_part_cells ||
      static_cast<double>(looks.gone) <
          parameters_.min_part_share * static_cast<double>(looks.looked_at())) {
    return;
  }
  CutGoneCells(object, map_);
}

}  // namespace

std::optional<PoseOffset> DecideSession(const MapConfig& config,
                                        const SessionIdentityParameters& parameters,
                                        const SensorName& source,
                                        const Eigen::Isometry3d& prior,
                                        WorkingMap* map) {
  return SessionDecision(config, parameters, source, prior, map).Run();
}

}  // namespace steadymap
