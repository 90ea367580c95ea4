#include "core/objects/session_identity.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/change/surface_looks.h"
#include "core/objects/changed_regions.h"
#include "core/objects/legs.h"
#include "core/objects/past_session.h"
#include "core/objects/place_matches.h"
#include "core/objects/session_alignment.h"
#include "core/objects/session_moves.h"
#include "core/objects/session_objects.h"
#include "core/objects/session_outcomes.h"
#include "core/objects/session_parts.h"
#include "core/objects/standing.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/wrong_labels.h"
#include "core/volume/free_space.h"

namespace steadymap {
namespace {

// A motion below this share of a voxel is lost in its interpolation.
constexpr double kNegligibleMotionVoxels = 0.1;

/// The decision on one session.
class SessionDecision {
 public:
  SessionDecision(const MapConfig& config,
                  const SessionIdentityParameters& parameters,
                  const SensorName& source,
                  WorkingMap* map)
      : parameters_(parameters),
        source_(source),
        map_(map),
        outcomes_(config, parameters, source, map) {}

  std::optional<PoseOffset> Run() {
    TakeSessionLooks();
    CompleteSessionObjects(parameters_.parts, source_, map_);
    FindDeparted();
    CutGone();
    ListObjects();
    Align();
    is_of_past_ = IsOfPast(objects_, map_->now(), parameters_.max_pause_s);
    if (is_of_past_) FindRemovedSince(*map_, &objects_);
    SeparateNew();
    MatchInPlace();
    AddDeparted();
    JudgeKnown();
    SeparateGone();
    AddRestsToStructures();
    FindMoves();
    if (FindReplaced()) FindMoves();
    MatchDoubted();
    AddRest();
    EndGone();
    for (TrackedObject* object : map_->AllObjects()) {
      if (object->state().status != ObjectStatus::kTentative) outcomes_.Settle(object);
    }
    return offset_;
  }

 private:
  Timestamp StartOfSession() const;
  void TakeSessionLooks();
  void ListObjects();
  void SeparateNew();
  void SeparateNewOn(KnownObject* structure, SeenObject* seen);
  void SeparateGone();
  void SeparateGoneOf(TrackedObject* object);
  void AddRestsToStructures();
  void Align();
  void Move(const Eigen::Isometry3d& motion, TrackedObject* object);
  void MatchInPlace();
  bool HasLeftPlace(const PlaceMatch& match) const;
  void ConfirmDeparted(const PlaceMatch& match);
  void AddDeparted();
  void MatchDoubted();
  void Confirm(SeenObject* seen, KnownObject* known);
  void JudgeKnown();
  void FindDeparted();
  void CutGone();
  void FindMoves();
  bool FindReplaced();
  void AddRest();
  bool IsPartOfKnown(const TrackedObject& seen);
  void EndGone();
  bool HasGoneParts(const TrackedObject& object) const;
  void CutGoneParts(TrackedObject* object);

  const SessionIdentityParameters& parameters_;
  const SensorName& source_;
  WorkingMap* map_;
  SessionOutcomes outcomes_;
  SessionObjects objects_;
  std::set<const TrackedObject*>
      departed_;  ///< Objects that later frames of the session found gone.
  std::vector<const TrackedObject*> moved_;  ///< Known objects that are at a new place.
  std::vector<std::pair<SeenObject*, KnownObject*>> rests_;  ///< Parts of structures.
  bool is_of_past_ = false;                                  ///< See `past_session.h`.
  std::optional<PoseOffset> offset_;                         ///< Of the poses of the session.
};

/// Returns the time of the first frame of the session; if it had none, of the last frame.
Timestamp SessionDecision::StartOfSession() const {
  const RobotState* robot = map_->FindRobot(source_);
  return robot == nullptr ? map_->now() : robot->session_start.value_or(map_->now());
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

/// Finds the objects that were seen and then found gone in the same session. Deletes wrong labels.
void SessionDecision::FindDeparted() {
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    const LookCount looks = CountLooks(*object);
    if (looks.looked_at() < parameters_.parts.min_points ||
        static_cast<double>(looks.gone) <
            parameters_.parts.shares.majority * static_cast<double>(looks.looked_at())) {
      continue;
    }
    if (HasSurfaceOfOther(*object, source_, parameters_.parts, *map_)) {
      map_->Delete(object);
    } else {
      departed_.insert(object);
    }
  }
}

/// Deletes what is gone of objects that stand, and what is too small without it.
void SessionDecision::CutGone() {
  for (TrackedObject* object : map_->TentativeObjectsOf(source_)) {
    if (departed_.contains(object)) continue;
    CutGoneCells(object, map_);
    if (IsTooSmall(*object, parameters_.parts)) map_->Delete(object);
  }
}

void SessionDecision::ListObjects() {
  for (TrackedObject* object : map_->AllObjects()) {
    if (object->is_deleted()) continue;
    if (IsInSession(object->state(), source_)) {
      objects_.AddSeen(object, departed_.contains(object));
    } else if (object->state().status != ObjectStatus::kTentative) {
      objects_.AddKnown(object, Standing::kUnknown);
    }
  }
}

/// Corrects the offset of the session by the objects that stand where they stood.
void SessionDecision::Align() {
  std::vector<const TrackedObject*> seen_objects;
  for (const SeenObject& seen : objects_.seen) seen_objects.push_back(seen.object);
  std::vector<const TrackedObject*> known_objects;
  for (const KnownObject& known : objects_.known) {
    if (!known.object->is_archived()) known_objects.push_back(known.object);
  }
  offset_ = AlignSession(seen_objects, known_objects, parameters_, map_->scale());
  if (offset_) objects_.motion = offset_->ToIsometry();
  for (const SeenObject& seen : objects_.seen) Move(objects_.motion, seen.object);
}

void SessionDecision::Move(const Eigen::Isometry3d& motion, TrackedObject* object) {
  const Eigen::Vector3d center_world = object->BoundsInWorld().center();
  const double displacement_m = (motion * center_world - center_world).norm();
  if (displacement_m < kNegligibleMotionVoxels * map_->scale().voxel_size_m) return;
  ObjectEdit edit = map_->Edit(object);
  edit.state().T_world_object = UprightPoseOf(motion * object->state().T_world_object.ToIsometry());
}

void SessionDecision::MatchInPlace() {
  const std::vector<PlaceMatch> matches = FindPlaceMatches(parameters_, map_->scale(), &objects_);
  for (SeenObject& seen : objects_.seen) {
    seen.pose_error_m = InPlaceLimit(matches, seen, parameters_);
  }
  for (PlaceMatch match : matches) {
    if (match.seen->is_decided) continue;
    const bool is_archived = match.known->object->is_archived();
    if (HasLeftPlace(match)) {
      ConfirmDeparted(match);
      continue;
    }
    const double doubt = DoubtOf(*match.known->object, objects_, parameters_);
    const double displacement_m = match.fits_at_rest && doubt < parameters_.parts.shares.negligible
                                      ? 0.0
                                      : match.displacement_m;
    if (IsOlderThanRemoval(*match.seen, *match.known)) {
      // Another session has found it gone since.
      if (displacement_m > match.seen->pose_error_m) continue;
      match.seen->is_decided = true;
      map_->Delete(match.seen->object);
      continue;
    }
    // What was gone is back where it stood, if not to the centimetre.
    if (!is_archived && displacement_m > match.seen->pose_error_m) continue;
    const bool is_displaced = displacement_m > parameters_.max_displacement_m;
    if (doubt >= (is_displaced ? parameters_.parts.shares.majority
                               : parameters_.parts.shares.nearly_all())) {
      continue;
    }
    if (!is_archived) {
      match.close_share =
          CompareInPlace(
              *match.seen->object, *match.known->object, parameters_.parts.surface, map_->scale())
              .close_share();
    }
    // A move could explain the surface clearly better.
    const bool may_be_moved = match.close_share < parameters_.parts.shares.nearly_all();
    if (doubt >= (is_displaced ? parameters_.parts.shares.negligible
                               : parameters_.parts.shares.majority) ||
        may_be_moved) {
      objects_.doubted.push_back(match);
    } else {
      Confirm(match.seen, match.known);
    }
  }
}

/// True if the session saw a known object in place and found it gone afterwards: by what it has
/// seen of it, or by the rest of the surface of the known one.
bool SessionDecision::HasLeftPlace(const PlaceMatch& match) const {
  if (match.displacement_m > match.seen->pose_error_m && !match.fits_at_rest) return false;
  if (match.seen->has_left) return true;
  if (match.known->object->is_archived()) return false;
  const LookCount looks = CountLooks(*match.known->object, match.seen->object->state().last_seen);
  return looks.gone >= looks.DecidingCells(parameters_.parts.min_points) &&
         static_cast<double>(looks.gone) >=
             parameters_.parts.shares.most() * static_cast<double>(looks.looked_at()) &&
         GoneShareOf(*match.known->object) >= parameters_.parts.shares.majority;
}

/// Makes one object of a known one and of what the session saw in its place until it left. If
/// another object of the session shows that the known one stands, what left is an error.
void SessionDecision::ConfirmDeparted(const PlaceMatch& match) {
  if (match.known->standing == Standing::kStands) {
    match.seen->is_decided = true;
    map_->Delete(match.seen->object);
    return;
  }
  Confirm(match.seen, match.known);
  match.known->is_taken = false;
  match.known->standing =
      outcomes_.IsContradicted(match.known->object) ? Standing::kContradicted : Standing::kGone;
}

/// Makes known objects of those that were seen for the first time and then found gone.
void SessionDecision::AddDeparted() {
  for (SeenObject& seen : objects_.seen) {
    if (!seen.has_left || seen.is_decided) continue;
    seen.is_decided = true;
    outcomes_.Create(seen.object);
    objects_.AddKnown(seen.object, Standing::kGone);
  }
}

/// Confirms the doubted matches in place that no move explains better.
void SessionDecision::MatchDoubted() {
  std::map<ObjectId, TrackedObject*> confirmed;
  for (const PlaceMatch& match : objects_.doubted) {
    if (match.seen->is_decided || match.known->is_taken) continue;
    Confirm(match.seen, match.known);
    confirmed.emplace(match.known->object->id(), match.known->object);
  }
  for (const auto& [id, object] : confirmed) SeparateGoneOf(object);
}

void SessionDecision::Confirm(SeenObject* seen, KnownObject* known) {
  TrackedObject* object = known->object;
  seen->is_decided = true;
  known->standing = Standing::kStands;
  // A fragment does not tell where the rest is.
  known->is_taken =
      known->is_taken ||
      seen->object->SurfaceAreaM2() >= parameters_.parts.fragment_share * object->SurfaceAreaM2();
  CutRemovedSince(*seen, map_);
  if (!HasGivenExtent(object->state()) && !object->is_archived()) {
    for (TrackedObject* region :
         SeparateNewRegions(parameters_.parts, *object, seen->object, map_)) {
      objects_.AddRegion(region, *seen);
    }
  }
  outcomes_.Confirm(seen->object, object);
}

void SessionDecision::JudgeKnown() {
  for (KnownObject& known : objects_.known) {
    if (known.standing != Standing::kUnknown || known.object->is_archived()) continue;
    std::vector<const TrackedObject*> others;
    const bool is_structure = IsStructure(*known.object, parameters_.parts.scene);
    for (const SeenObject& seen : objects_.seen) {
      // A thing on a structure does not replace it.
      if (!seen.is_decided && !is_structure && IsOfOneClass(*seen.object, *known.object)) {
        others.push_back(seen.object);
      }
    }
    known.standing = JudgeStanding(*known.object, others, parameters_, map_->scale());
    if (known.standing == Standing::kGone && outcomes_.IsContradicted(known.object)) {
      known.standing = Standing::kContradicted;
    }
  }
}

/// Separates what is new on structures from what had not been seen of them.
void SessionDecision::SeparateNew() {
  for (KnownObject& known : objects_.known) {
    if (!IsStructure(*known.object, parameters_.parts.scene)) continue;
    const std::size_t count = objects_.seen.size();
    for (std::size_t i = 0; i < count; ++i) {
      SeenObject& seen = objects_.seen[i];
      if (HasGivenExtent(seen.object->state()) || seen.is_decided) continue;
      SeparateNewOn(&known, &seen);
    }
  }
}

/// Separates what is new in an object of the session on a structure. The rest, in contact with the
/// structure, is a part of it.
void SessionDecision::SeparateNewOn(KnownObject* structure, SeenObject* seen) {
  if (seen->is_new_region) return;
  for (TrackedObject* region :
       SeparateNewRegions(parameters_.parts, *structure->object, seen->object, map_)) {
    objects_.AddRegion(region, *seen);
  }
  const bool is_rest = seen->object->surface().point_count() > 0;
  if (is_rest && !AreInContact(*seen->object, *structure->object, parameters_.parts, map_->scale()))
    return;
  seen->is_decided = true;
  if (is_rest) {
    rests_.emplace_back(seen, structure);
  } else {
    map_->Delete(seen->object);
  }
}

/// Ends the regions of standing objects that are gone.
void SessionDecision::SeparateGone() {
  const std::size_t count = objects_.known.size();
  for (std::size_t i = 0; i < count; ++i) {
    TrackedObject* object = objects_.known[i].object;
    if (objects_.known[i].standing != Standing::kStands || object->is_archived()) continue;
    if (IsStructure(*object, parameters_.parts.scene)) outcomes_.ConfirmStructure(object);
    SeparateGoneOf(object);
  }
}

/// Ends the regions of one object that are gone. Neighbours of one class may be one object, but a
/// few cells of an object with a label are errors.
void SessionDecision::SeparateGoneOf(TrackedObject* object) {
  if (HasGivenExtent(object->state()) && !HasGoneParts(*object)) return;
  for (TrackedObject* region : SeparateGoneRegions(parameters_.parts, object, map_)) {
    objects_.AddGonePart(region, *object);
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

/// Joins objects of the session with the gone, pushed or archived objects whose shape they have.
void SessionDecision::FindMoves() {
  const FreeSpaceSince free_space(map_->free_space(), StartOfSession());
  for (const SessionMove& move : FindSessionMoves(parameters_, free_space, *map_, &objects_)) {
    KnownObject& known = *move.known;
    const bool is_outdated = IsOlderThanLastLook(*move.seen, known);
    // `JudgeKnown` has asked whether what is gone is contradicted. The past contradicts nothing.
    const bool may_be_contradicted = !known.object->is_archived() &&
                                     known.standing != Standing::kGone &&
                                     !(is_outdated && is_of_past_);
    if (may_be_contradicted &&
        (known.standing == Standing::kContradicted || outcomes_.IsContradicted(known.object))) {
      known.standing = Standing::kContradicted;
      continue;
    }
    move.seen->is_decided = true;
    if (is_outdated) {
      // The session saw it before it was moved.
      map_->Delete(move.seen->object);
      continue;
    }
    outcomes_.Join(move.match, known.object, move.seen->object);
    known.standing = Standing::kStands;
    known.is_taken = true;
    moved_.push_back(known.object);
  }
}

/// Finds the known objects that cannot stand where an object of their class is that was moved
/// there: what the looks found of them is its surface. Without a class, one may be in the hollow of
/// the other. Returns false if there are none.
bool SessionDecision::FindReplaced() {
  bool has_found = false;
  for (KnownObject& known : objects_.known) {
    const bool may_stand =
        known.standing == Standing::kStands || known.standing == Standing::kUnverified;
    if (!may_stand || known.is_taken || known.object->is_archived() ||
        known.object->state().class_id == kNoClass) {
      continue;
    }
    const bool is_replaced =
        std::any_of(moved_.begin(), moved_.end(), [&](const TrackedObject* moved) {
          return IsOfOneClass(*moved, *known.object) &&
                 ShareSpace(*moved, *known.object, parameters_.parts.shares);
        });
    if (!is_replaced || outcomes_.IsContradicted(known.object)) continue;
    known.standing = Standing::kGone;
    has_found = true;
  }
  return has_found;
}

/// True if an object of the session continues a known one that stands, or that the session hardly
/// looked at, which then has its surface.
bool SessionDecision::IsPartOfKnown(const TrackedObject& seen) {
  const bool is_leg = IsOpenLeg(seen, parameters_.parts, *map_);
  for (const KnownObject& known : objects_.known) {
    const bool may_stand = known.standing == Standing::kStands ||
                           (known.standing == Standing::kUnknown && !known.object->is_archived());
    if (!may_stand || !IsOfOneClass(seen, *known.object)) continue;
    if (!IsPartOf(seen, *known.object, parameters_.parts, *map_) &&
        !(is_leg && MayBeLegOf(seen, *known.object, parameters_.parts)) &&
        !AreInContact(seen, *known.object, parameters_.parts, map_->scale())) {
      continue;
    }
    // Where free space was seen before, the known one has no surface.
    if (NewShareOf(parameters_.parts, *known.object, seen, *map_) >=
        parameters_.parts.shares.majority) {
      continue;
    }
    AddVoxels(seen, map_, known.object);
    return true;
  }
  return false;
}

void SessionDecision::AddRest() {
  for (SeenObject& seen : objects_.seen) {
    if (seen.is_decided) continue;
    // No later session found it, so a part of its surface decides.
    const bool is_outdated = seen.removed_share >= parameters_.parts.shares.negligible;
    if (is_outdated || IsTooSmall(*seen.object, parameters_.parts) ||
        (!seen.is_new_region && IsPartOfKnown(*seen.object))) {
      map_->Delete(seen.object);
      continue;
    }
    outcomes_.Create(seen.object);
  }
}

void SessionDecision::EndGone() {
  for (const KnownObject& known : objects_.known) {
    if (known.object->is_archived()) continue;
    if (known.standing == Standing::kStands) CutGoneParts(known.object);
    if (known.standing == Standing::kContradicted) outcomes_.KeepContradicted(known.object);
    if (known.standing == Standing::kGone) outcomes_.Remove(known.object, known.part_of);
  }
}

/// True if a part of an object that stands is gone.
bool SessionDecision::HasGoneParts(const TrackedObject& object) const {
  const LookCount looks = CountLooks(object);
  return looks.gone >= parameters_.min_part_cells &&
         static_cast<double>(looks.gone) >=
             parameters_.parts.shares.negligible * static_cast<double>(looks.looked_at());
}

/// Takes the surface that is gone off an object that stands.
void SessionDecision::CutGoneParts(TrackedObject* object) {
  if (HasGoneParts(*object)) CutGoneCells(object, map_);
}

}  // namespace

std::optional<PoseOffset> DecideSession(const MapConfig& config,
                                        const SessionIdentityParameters& parameters,
                                        const SensorName& source,
                                        WorkingMap* map) {
  return SessionDecision(config, parameters, source, map).Run();
}

}  // namespace steadymap
