#include "core/objects/session_identity.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/change/belief_update.h"
#include "core/change/surface_looks.h"
#include "core/objects/session_parts.h"
#include "core/objects/shape_match.h"
#include "core/registration/anchored_alignment.h"
#include "core/registration/registration.h"
#include "core/volume/tsdf_sample.h"
#include "core/working/object_split.h"

namespace steadymap {
namespace {

// Points of a thing that take part in the alignment of a session.
constexpr std::size_t kMaxAnchorPoints = 400;

// Standard deviation of a normal distribution, in medians of its magnitude.
constexpr double kSigmasOfMedian = 1.4826;

// A motion below this share of a voxel is lost in its interpolation.
constexpr double kNegligibleMotionVoxels = 0.1;

/// The verdict on a known object.
enum class Standing { kUnknown, kStands, kGone };

struct KnownObject {
  TrackedObject* object = nullptr;
  Standing standing = Standing::kUnknown;
  bool is_taken = false;  ///< By an object of the session.
};

/// An object of the session.
struct SeenObject {
  TrackedObject* object = nullptr;
  bool is_decided = false;
};

/// An object of the session on the surface of a known one.
struct PlaceMatch {
  SeenObject* seen = nullptr;
  KnownObject* known = nullptr;
  double displacement_m = 0.0;
  double fit = 0.0;  ///< Share of the surface that agrees.
};

/// Returns the share of the looked-at surface that is gone.
double GoneShareOf(const TrackedObject& object) {
  const LookCount looks = CountLooks(object);
  if (looks.looked_at() == 0) return 0.0;
  return static_cast<double>(looks.gone) / static_cast<double>(looks.looked_at());
}

/// Returns the largest displacement that a correction means for a thing.
double DisplacementOf(const Registration& registration, const TrackedObject& object) {
  const double radius_m = 0.5 * object.cuboid().size_m.head<2>().norm();
  return std::hypot(registration.shift_world.norm(), registration.yaw_rad * radius_m);
}

/// The decision on one session.
class SessionDecision {
 public:
  SessionDecision(const MapConfig& config,
                  const SessionIdentityParameters& parameters,
                  WorkingMap* map)
      : config_(config), parameters_(parameters), map_(map) {}

  void Run() {
    CompleteSessionObjects(parameters_.parts, map_);
    EndVanished();
    for (TrackedObject* object : map_->TentativeObjects()) CutGoneCells(object);
    ListObjects();
    Align();
    MatchInPlace();
    JudgeKnown();
    FindMoves();
    MatchDoubted();
    AddRest();
    EndGone();
    for (TrackedObject* object : map_->AllObjects()) {
      if (object->state().evidence == ObjectEvidence() && object->state().parts.empty()) continue;
      ObjectEdit edit = map_->Edit(object);
      edit.state().evidence = {};
      edit.state().parts.clear();
    }
  }

 private:
  void ListObjects();
  void Align();
  AnchorMatches MatchesOf(const TrackedObject& seen,
                          const TrackedObject& known,
                          const Eigen::Isometry3d& T_correction) const;
  void Move(const Eigen::Isometry3d& motion, TrackedObject* object);
  std::optional<Registration> Register(const TrackedObject& seen, const TrackedObject& known) const;
  double InPlaceLimit(const std::vector<PlaceMatch>& matches, const SeenObject& seen) const;
  std::vector<PlaceMatch> FindPlaceMatches();
  void MatchInPlace();
  double DoubtOf(const TrackedObject& known) const;
  void MatchDoubted();
  double DoubtedFitOf(const SeenObject& seen, const KnownObject& known) const;
  bool IsDoubtedMatch(const SeenObject& seen, const KnownObject& known) const;
  void Confirm(SeenObject* seen, KnownObject* known);
  void JudgeKnown();
  bool IsVacated(const TrackedObject& known, const LookCount& looks) const;
  void EndVanished();
  void FindMoves();
  void Join(TrackedObject* before, TrackedObject* after, const ShapeMatch& match);
  void Create(TrackedObject* object);
  void AddRest();
  bool IsPartOfStanding(const TrackedObject& seen);
  void EndGone();
  void CutGoneParts(TrackedObject* object);
  void CutGoneCells(TrackedObject* object);
  void UpdateBeliefOf(double change_m, TrackedObject* object);

  const MapConfig& config_;
  const SessionIdentityParameters& parameters_;
  WorkingMap* map_;
  std::vector<SeenObject> seen_;
  std::vector<KnownObject> known_;
  Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity();  ///< Onto the map, of the session.
  std::vector<PlaceMatch> doubted_;  ///< In place, but much of the known object is gone.
};

/// Makes known objects of those that were seen and then found gone in the same session.
void SessionDecision::EndVanished() {
  for (TrackedObject* object : map_->TentativeObjects()) {
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
    edit.state().in_place_since = object->state().first_seen;
  }
  map_->RecordEvent(map_->MakeEvent(EventType::kCreated, EventReason::kNewSurface, *object));
}

void SessionDecision::ListObjects() {
  for (TrackedObject* object : map_->AllObjects()) {
    if (object->is_deleted()) continue;
    if (object->state().status == ObjectStatus::kTentative) {
      seen_.push_back({object});
    } else {
      known_.push_back({object});
    }
  }
}

/// Registers an object of the session to a known one; none if they are of different classes or far
/// apart.
std::optional<Registration> SessionDecision::Register(const TrackedObject& seen,
                                                      const TrackedObject& known) const {
  if (!IsOfOneClass(seen, known)) return std::nullopt;
  const Eigen::Vector3d margin =
      Eigen::Vector3d::Constant(RegistrationParameters().search_distance_m);
  Box reach_world = seen.BoundsInWorld();
  reach_world = Box(reach_world.min() - margin, reach_world.max() + margin);
  if (!reach_world.intersects(known.BoundsInWorld())) return std::nullopt;
  return RegisterPoints(
      seen.SurfaceInWorld(), known.volume(), map_->scale(), known.state().T_world_object);
}

AnchorMatches SessionDecision::MatchesOf(const TrackedObject& seen,
                                         const TrackedObject& known,
                                         const Eigen::Isometry3d& T_correction) const {
  const Eigen::Isometry3d T_world_known = known.state().T_world_object.ToIsometry();
  const Eigen::Isometry3d T_known_world = T_world_known.inverse();
  TsdfSampler sampler(known.volume(), map_->scale());
  const std::vector<Eigen::Vector3d> points_world = seen.SurfaceInWorld();
  const std::size_t stride = points_world.size() / kMaxAnchorPoints + 1;
  AnchorMatches matches;
  for (std::size_t i = 0; i < points_world.size(); i += stride) {
    const Eigen::Vector3d moved_world = T_correction * points_world[i];
    const DistanceSample sample = sampler.Sample(T_known_world * moved_world);
    if (!sample.known || std::abs(sample.distance_m) > map_->scale().voxel_size_m) continue;
    const Eigen::Vector3d normal_world = T_world_known.linear() * sample.gradient;
    matches.push_back(
        {points_world[i], moved_world - sample.distance_m * normal_world, normal_world});
  }
  return matches;
}

/// Corrects the offset of the session by the objects that stand where they stood.
void SessionDecision::Align() {
  std::vector<AnchorMatches> anchors;
  std::vector<Eigen::Isometry3d> starts;
  for (const SeenObject& seen : seen_) {
    for (const KnownObject& known : known_) {
      if (known.object->state().status != ObjectStatus::kPresent) continue;
      const std::optional<Registration> registration = Register(*seen.object, *known.object);
      if (!registration || registration->dissimilarity > parameters_.max_dissimilarity ||
          registration->known_share < parameters_.min_shape_known_share) {
        continue;
      }
      anchors.push_back(MatchesOf(*seen.object, *known.object, registration->T_correction));
      starts.push_back(registration->T_correction);
    }
  }
  if (anchors.empty()) return;
  const double scale_m = std::max(parameters_.vote_scale_m, 0.5 * map_->scale().voxel_size_m);
  motion_ = AlignToAnchors(anchors, starts, scale_m, parameters_.claim_votes);
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
  return std::max(parameters_.max_displacement_m,
                  parameters_.max_pose_sigmas * kSigmasOfMedian * *middle);
}

/// Returns the known objects that each object of the session may be, in place or almost.
std::vector<PlaceMatch> SessionDecision::FindPlaceMatches() {
  std::vector<PlaceMatch> matches;
  for (SeenObject& seen : seen_) {
    for (KnownObject& known : known_) {
      const std::optional<Registration> registration = Register(*seen.object, *known.object);
      const double least_known = known.object->is_archived() ? parameters_.min_shape_known_share
                                                             : parameters_.min_known_share;
      if (!registration || registration->dissimilarity > parameters_.max_dissimilarity ||
          registration->known_share < least_known) {
        continue;
      }
      const double fit = registration->known_share * (1.0 - registration->dissimilarity);
      matches.push_back({&seen, &known, DisplacementOf(*registration, *seen.object), fit});
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
    // What was gone is back where it stood, if not to the centimetre.
    if (!match.known->object->is_archived() &&
        match.displacement_m > InPlaceLimit(matches, *match.seen)) {
      continue;
    }
    if (DoubtOf(*match.known->object) >= parameters_.doubted_share) {
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
  AddVoxels(*seen->object, map_, object);
  const bool is_back = object->is_archived();
  {
    ObjectEdit edit = map_->Edit(object);
    ObjectState& state = edit.state();
    if (is_back) {
      state.status = ObjectStatus::kPresent;
      state.in_place_since = seen->object->state().first_seen;
      state.belief = InitialBelief(parameters_.initial_stationarity);
    }
    state.last_seen = seen->object->state().last_seen;
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

/// True if an undecided object of the session is where a known one was, so that it cannot be there.
bool SessionDecision::IsVacated(const TrackedObject& known, const LookCount& looks) const {
  const bool is_doubted = static_cast<double>(looks.gone) >=
                          parameters_.doubted_share * static_cast<double>(looks.looked_at());
  return std::any_of(seen_.begin(), seen_.end(), [&](const SeenObject& seen) {
    if (seen.is_decided || !IsOfOneClass(*seen.object, known)) return false;
    if (!is_doubted) {
      const std::optional<Registration> registration = Register(*seen.object, known);
      return registration && registration->dissimilarity <= parameters_.max_dissimilarity &&
             registration->known_share >= parameters_.min_displaced_known_share &&
             DisplacementOf(*registration, *seen.object) > parameters_.max_displacement_m;
    }
    const Cuboid& a = seen.object->cuboid();
    const Cuboid& b = known.cuboid();
    const double smaller_m3 = std::min(a.volume_m3(), b.volume_m3());
    return OverlapM3(a, b) > parameters_.max_overlap_share * smaller_m3;
  });
}

void SessionDecision::JudgeKnown() {
  for (KnownObject& known : known_) {
    if (known.standing != Standing::kUnknown || known.object->is_archived()) continue;
    const LookCount looks = CountLooks(*known.object);
    if (looks.looked_at() < parameters_.min_looked_at_cells) continue;
    const bool is_gone = static_cast<double>(looks.gone) >=
                         parameters_.gone_share * static_cast<double>(looks.looked_at());
    known.standing =
        is_gone || IsVacated(*known.object, looks) ? Standing::kGone : Standing::kStands;
  }
}

/// Joins objects of the session with the gone or archived objects whose shape they have.
void SessionDecision::FindMoves() {
  struct Candidate {
    SeenObject* seen;
    KnownObject* known;
    ShapeMatch match;
    double distance_m;
  };

  std::vector<Candidate> candidates;
  for (SeenObject& seen : seen_) {
    if (seen.is_decided) continue;
    for (KnownObject& known : known_) {
      if (!IsOfOneClass(*seen.object, *known.object)) continue;
      if (known.standing != Standing::kGone && !known.object->is_archived()) continue;
      if (known.is_taken || IsDoubtedMatch(seen, known)) continue;
      if (seen.object->SurfaceAreaM2() <
          parameters_.min_moved_area_share * known.object->SurfaceAreaM2()) {
        continue;
      }
      const ShapeMatch match = MatchShapes(*known.object, *seen.object, map_->scale());
      if (match.overlap.known_share < parameters_.min_shape_known_share ||
          match.overlap.fit_share < parameters_.min_shape_fit_share) {
        continue;
      }
      const double distance_m = DistanceBetween(known.object->cuboid(), seen.object->cuboid());
      candidates.push_back({&seen, &known, match, distance_m});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    return a.match.confidence() > b.match.confidence();
  });
  for (const Candidate& candidate : candidates) {
    if (candidate.seen->is_decided || candidate.known->is_taken ||
        DoubtedFitOf(*candidate.seen, *candidate.known) >= candidate.match.confidence()) {
      continue;
    }
    const bool has_rival =
        std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& rival) {
          if (&rival == &candidate || rival.seen->is_decided || rival.known->is_taken) {
            return false;
          }
          if (rival.seen != candidate.seen && rival.known != candidate.known) return false;
          // Of two equal shapes, the one whose place overlaps was pushed.
          if (candidate.distance_m <= 0.0 && rival.distance_m > 0.0) return false;
          return rival.match.confidence() > candidate.match.confidence() - parameters_.rival_margin;
        });
    if (has_rival) continue;
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
    state.belief = InitialBelief(parameters_.initial_stationarity);
    state.in_place_since = after->state().first_seen;
    state.last_seen = after->state().last_seen;
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
        !AreInContact(seen, *known.object, contact_m, map_->scale())) {
      continue;
    }
    AddVoxels(seen, map_, known.object);
    return true;
  }
  return false;
}

void SessionDecision::AddRest() {
  for (SeenObject& seen : seen_) {
    if (seen.is_decided) continue;
    if (IsPartOfStanding(*seen.object)) {
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
    edit.state().in_place_since = map_->now();
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
  CutGoneCells(object);
}

/// Takes the cells off an object that most looks found gone, or of another class.
void SessionDecision::CutGoneCells(TrackedObject* object) {
  if (CountLooks(*object).gone == 0) return;
  TrackedObject& part = map_->AddPart(*object);
  {
    ObjectEdit edit = map_->Edit(object);
    ObjectEdit part_edit = map_->Edit(&part);
    MoveGoneVoxels({-1, -1}, &edit, &part_edit);
  }
  map_->Delete(&part);
}

}  // namespace

void DecideSession(const MapConfig& config,
                   const SessionIdentityParameters& parameters,
                   WorkingMap* map) {
  SessionDecision(config, parameters, map).Run();
}

}  // namespace steadymap
