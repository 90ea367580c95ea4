#include "server/store/database/object_records.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/types/error.h"
#include "server/store/database/corrupt_record.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kStandings = 3;
constexpr std::uint32_t kEventTypes = static_cast<std::uint32_t>(EventType::kContradicted) + 1;
constexpr std::uint32_t kEventReasons = static_cast<std::uint32_t>(EventReason::kAgreement) + 1;
constexpr std::uint32_t kMaxClassId = 0xFFFF;
constexpr std::int32_t kMaxLeafIndex = 1 << 27;

constexpr int kEvidenceNumbers = 2;

using Doubles = google::protobuf::RepeatedField<double>;

void Add(const Eigen::Vector3d& vector, Doubles* numbers) {
  for (const double number : vector) numbers->Add(number);
}

Eigen::Vector3d VectorAt(const Doubles& numbers, int first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

void BeliefToProto(const Belief& belief, storage::v1::Belief* proto) {
  proto->set_change_mean_m(belief.change_mean_m);
  proto->set_change_std_m(belief.change_std_m);
  proto->set_alpha(belief.alpha);
  proto->set_beta(belief.beta);
}

Belief BeliefFromProto(const storage::v1::Belief& proto) {
  return {proto.change_mean_m(), proto.change_std_m(), proto.alpha(), proto.beta()};
}

bool IsPossible(const Belief& belief) {
  return std::isfinite(belief.change_mean_m) && belief.change_std_m > 0.0 && belief.alpha > 0.0 &&
         belief.beta > 0.0;
}

void LeafToProto(const LeafEvidence& leaf, storage::v1::LeafEvidence* proto) {
  proto->set_x(leaf.origin.x / kLeafSide);
  proto->set_y(leaf.origin.y / kLeafSide);
  proto->set_z(leaf.origin.z / kLeafSide);
  std::string scores;
  scores.reserve(leaf.score.size());
  for (const std::int8_t score : leaf.score) scores.push_back(static_cast<char>(score));
  const std::size_t last = scores.find_last_not_of('\0');
  scores.resize(last == std::string::npos ? 0 : last + 1);
  proto->set_scores(std::move(scores));
  proto->set_last_look_ns(leaf.last_look.nanoseconds());
}

absl::StatusOr<LeafEvidence> LeafFromProto(const storage::v1::LeafEvidence& proto) {
  LeafEvidence leaf;
  for (const std::int32_t index : {proto.x(), proto.y(), proto.z()}) {
    if (index < -kMaxLeafIndex || index >= kMaxLeafIndex) {
      return CorruptRecord("an object record contains a leaf index that is out of range");
    }
  }
  leaf.origin = {proto.x() * kLeafSide, proto.y() * kLeafSide, proto.z() * kLeafSide};
  if (proto.scores().size() > leaf.score.size()) {
    return CorruptRecord("an object record contains too many scores for a leaf");
  }
  std::transform(proto.scores().begin(), proto.scores().end(), leaf.score.begin(), [](char score) {
    return static_cast<std::int8_t>(score);
  });
  leaf.last_look = Timestamp::FromNanoseconds(proto.last_look_ns());
  return leaf;
}

absl::Status ReadLeaves(const google::protobuf::RepeatedPtrField<storage::v1::LeafEvidence>& proto,
                        std::vector<LeafEvidence>* leaves) {
  leaves->reserve(static_cast<std::size_t>(proto.size()));
  for (const storage::v1::LeafEvidence& leaf : proto) {
    absl::StatusOr<LeafEvidence> read = LeafFromProto(leaf);
    if (!read.ok()) return read.status();
    if (!leaves->empty() && !(leaves->back().origin < read->origin)) {
      return CorruptRecord("the evidence leaves of an object record are not sorted");
    }
    leaves->push_back(*std::move(read));
  }
  return absl::OkStatus();
}

absl::Status ReadEvidence(const storage::v1::ObjectState& proto, ObjectEvidence* evidence) {
  evidence->present_cells = proto.evidence_cells(0);
  evidence->absent_cells = proto.evidence_cells(1);
  if (!std::isfinite(evidence->present_cells) || !std::isfinite(evidence->absent_cells)) {
    return CorruptRecord("an object record contains a number of cells that is not finite");
  }
  return ReadLeaves(proto.evidence(), &evidence->leaves);
}

absl::Status ReadLooks(const storage::v1::ObjectState& proto, std::vector<SessionLooks>* looks) {
  if (static_cast<std::size_t>(proto.looks_size()) > kMaxLookingSessions) {
    return CorruptRecord("an object record contains the looks of too many sessions");
  }
  for (const storage::v1::SessionLooks& session : proto.looks()) {
    SessionLooks read{{session.robot(), session.sensor()}, {}};
    if (!looks->empty() && !(looks->back().source < read.source)) {
      return CorruptRecord("the sessions of an object record are not sorted");
    }
    if (absl::Status status = ReadLeaves(session.evidence(), &read.leaves); !status.ok()) {
      return status;
    }
    looks->push_back(std::move(read));
  }
  return absl::OkStatus();
}

void ContradictionToProto(const Contradiction& contradiction, storage::v1::Contradiction* proto) {
  proto->set_present_robot(contradiction.present.robot);
  proto->set_present_sensor(contradiction.present.sensor);
  proto->set_absent_robot(contradiction.absent.robot);
  proto->set_absent_sensor(contradiction.absent.sensor);
  proto->set_since_ns(contradiction.since.nanoseconds());
  proto->set_last_ns(contradiction.last.nanoseconds());
  proto->set_sessions(contradiction.sessions);
}

absl::Status ReadContradictions(const storage::v1::ObjectState& proto,
                                std::vector<Contradiction>* contradictions) {
  if (static_cast<std::size_t>(proto.contradictions_size()) > kMaxContradictions) {
    return CorruptRecord("an object record contains too many contradictions");
  }
  for (const storage::v1::Contradiction& read : proto.contradictions()) {
    contradictions->push_back({.absent = {read.absent_robot(), read.absent_sensor()},
                               .present = {read.present_robot(), read.present_sensor()},
                               .since = Timestamp::FromNanoseconds(read.since_ns()),
                               .last = Timestamp::FromNanoseconds(read.last_ns()),
                               .sessions = read.sessions()});
  }
  return absl::OkStatus();
}

void GapToProto(const SeenGap& gap, storage::v1::SeenGap* proto) {
  for (const std::int32_t index : gap.cell) proto->add_cell(index);
  proto->set_frames(gap.frames);
  proto->set_weight(gap.weight);
  proto->set_width(gap.width_m);
  Add(gap.middle_world, proto->mutable_middle());
  proto->add_view(gap.view_sum_world.x());
  proto->add_view(gap.view_sum_world.y());
}

bool IsPossible(const SeenGap& gap) {
  return gap.frames > 0 && gap.weight > 0.0 && std::isfinite(gap.weight) && gap.width_m >= 0.0 &&
         std::isfinite(gap.width_m) && gap.middle_world.allFinite() &&
         gap.view_sum_world.allFinite();
}

absl::Status ReadGaps(const storage::v1::ObjectState& proto, std::vector<SeenGap>* gaps) {
  gaps->reserve(static_cast<std::size_t>(proto.gaps_size()));
  for (const storage::v1::SeenGap& read : proto.gaps()) {
    if (read.cell_size() != 3 || read.middle_size() != 3 || read.view_size() != 2) {
      return CorruptRecord("an object record contains an incomplete gap");
    }
    const SeenGap gap = {.cell = {read.cell(0), read.cell(1), read.cell(2)},
                         .frames = read.frames(),
                         .weight = read.weight(),
                         .width_m = read.width(),
                         .middle_world = VectorAt(read.middle(), 0),
                         .view_sum_world = {read.view(0), read.view(1)}};
    if (!IsPossible(gap)) return CorruptRecord("an object record contains an invalid gap");
    if (!gaps->empty() && gap.cell <= gaps->back().cell) {
      return CorruptRecord("an object record contains gaps out of order");
    }
    gaps->push_back(gap);
  }
  return absl::OkStatus();
}

}  // namespace

storage::v1::ObjectState ToProto(const ObjectState& state) {
  storage::v1::ObjectState proto;
  proto.set_standing(static_cast<std::uint32_t>(state.status) + 1);
  proto.set_revision(state.revision.value());
  proto.set_class_id(state.class_id.value());
  for (const ClassVote& vote : state.votes) {
    storage::v1::ClassVote& added = *proto.add_votes();
    added.set_class_id(vote.class_id.value());
    added.set_weight(vote.weight);
  }
  proto.set_has_given_extent(state.has_given_extent);
  Add(state.T_world_object.position_world, proto.mutable_pose());
  proto.add_pose(state.T_world_object.yaw_rad);
  Add(state.cuboid.center_world, proto.mutable_cuboid());
  Add(state.cuboid.size_m, proto.mutable_cuboid());
  proto.add_cuboid(state.cuboid.yaw_rad);
  BeliefToProto(state.belief, proto.mutable_belief());
  proto.add_evidence_cells(state.evidence.present_cells);
  proto.add_evidence_cells(state.evidence.absent_cells);
  for (const LeafEvidence& leaf : state.evidence.leaves) LeafToProto(leaf, proto.add_evidence());
  for (const SessionLooks& looks : state.looks) {
    storage::v1::SessionLooks& session = *proto.add_looks();
    session.set_robot(looks.source.robot);
    session.set_sensor(looks.source.sensor);
    for (const LeafEvidence& leaf : looks.leaves) LeafToProto(leaf, session.add_evidence());
  }
  proto.set_first_seen_ns(state.first_seen.nanoseconds());
  proto.set_standing_since_ns(state.in_place_since.nanoseconds());
  proto.set_last_seen_ns(state.last_seen.nanoseconds());
  proto.set_views(state.supporting_frames);
  proto.set_absences(state.contradicted_updates);
  for (const PartVotes& votes : state.parts) {
    storage::v1::PartVotes& added = *proto.add_parts();
    added.set_other(votes.other.value());
    added.set_connected(votes.connected);
    added.set_apart(votes.apart);
    added.set_occluded(votes.occluded);
  }
  for (const SeenGap& gap : state.gaps) GapToProto(gap, proto.add_gaps());
  proto.set_robot(state.source.robot);
  proto.set_sensor(state.source.sensor);
  for (const Contradiction& contradiction : state.contradictions) {
    ContradictionToProto(contradiction, proto.add_contradictions());
  }
  return proto;
}

absl::StatusOr<ObjectState> FromProto(ObjectId id, const storage::v1::ObjectState& proto) {
  if (proto.standing() < 1 || proto.standing() > kStandings || proto.class_id() > kMaxClassId ||
      proto.pose_size() != 4 || proto.cuboid_size() != 7 ||
      proto.evidence_cells_size() < kEvidenceNumbers) {
    return CorruptRecord("an object record does not contain a valid object");
  }
  ObjectState state;
  state.id = id;
  state.status = static_cast<ObjectStatus>(proto.standing() - 1);
  state.revision = Revision{proto.revision()};
  state.class_id = ClassId{static_cast<std::uint16_t>(proto.class_id())};
  state.votes.reserve(static_cast<std::size_t>(proto.votes_size()));
  for (const storage::v1::ClassVote& vote : proto.votes()) {
    if (vote.class_id() > kMaxClassId)
      return CorruptRecord("an object record contains a vote for an invalid class");
    state.votes.push_back({ClassId{static_cast<std::uint16_t>(vote.class_id())}, vote.weight()});
  }
  state.has_given_extent = proto.has_given_extent();
  state.T_world_object = {VectorAt(proto.pose(), 0), proto.pose(3)};
  state.cuboid = {VectorAt(proto.cuboid(), 0), VectorAt(proto.cuboid(), 3), proto.cuboid(6)};
  state.belief = BeliefFromProto(proto.belief());
  if (!IsPossible(state.belief))
    return CorruptRecord("an object record contains an invalid belief");
  if (absl::Status status = ReadEvidence(proto, &state.evidence); !status.ok()) return status;
  if (absl::Status status = ReadLooks(proto, &state.looks); !status.ok()) return status;
  state.first_seen = Timestamp::FromNanoseconds(proto.first_seen_ns());
  state.in_place_since = Timestamp::FromNanoseconds(proto.standing_since_ns());
  state.last_seen = Timestamp::FromNanoseconds(proto.last_seen_ns());
  state.supporting_frames = proto.views();
  state.contradicted_updates = proto.absences();
  state.parts.reserve(static_cast<std::size_t>(proto.parts_size()));
  for (const storage::v1::PartVotes& votes : proto.parts()) {
    state.parts.push_back(
        {ObjectId(votes.other()), votes.connected(), votes.apart(), votes.occluded()});
  }
  if (absl::Status status = ReadGaps(proto, &state.gaps); !status.ok()) return status;
  state.source = {proto.robot(), proto.sensor()};
  if (absl::Status status = ReadContradictions(proto, &state.contradictions); !status.ok()) {
    return status;
  }
  return state;
}

storage::v1::EventRecord ToProto(const ObjectEvent& event) {
  storage::v1::EventRecord record;
  record.set_type(static_cast<std::uint32_t>(event.type) + 1);
  record.set_reason(static_cast<std::uint32_t>(event.reason) + 1);
  record.set_object(event.object.value());
  record.set_class_id(event.class_id.value());
  record.set_time_ns(event.time.nanoseconds());
  record.set_revision(event.revision.value());
  Add(event.center_world, record.mutable_center());
  if (event.old_center_world) Add(*event.old_center_world, record.mutable_old_center());
  if (event.confidence) record.set_confidence(*event.confidence);
  if (event.move) {
    for (const UprightPose& pose : {event.move->T_world_before, event.move->T_world_after}) {
      Add(pose.position_world, record.mutable_move());
      record.add_move(pose.yaw_rad);
    }
  }
  BeliefToProto(event.before, record.mutable_before());
  BeliefToProto(event.after, record.mutable_after());
  record.set_related(event.related.value());
  record.set_views(event.supporting_frames);
  record.set_absences(event.contradicted_updates);
  record.set_robot(event.source.robot);
  record.set_sensor(event.source.sensor);
  return record;
}

absl::StatusOr<ObjectEvent> FromProto(const storage::v1::EventRecord& record) {
  if (record.type() < 1 || record.type() > kEventTypes || record.reason() < 1 ||
      record.reason() > kEventReasons || record.class_id() > kMaxClassId ||
      record.center_size() != 3 || record.old_center_size() % 3 != 0 ||
      record.old_center_size() > 3 || (record.move_size() != 0 && record.move_size() != 8)) {
    return CorruptRecord("an event record does not contain a valid event");
  }
  ObjectEvent event;
  event.type = static_cast<EventType>(record.type() - 1);
  event.reason = static_cast<EventReason>(record.reason() - 1);
  event.object = ObjectId{record.object()};
  event.class_id = ClassId{static_cast<std::uint16_t>(record.class_id())};
  event.time = Timestamp::FromNanoseconds(record.time_ns());
  event.revision = Revision{record.revision()};
  event.center_world = VectorAt(record.center(), 0);
  if (record.old_center_size() == 3) event.old_center_world = VectorAt(record.old_center(), 0);
  if (record.has_confidence()) event.confidence = record.confidence();
  if (record.move_size() == 8) {
    event.move = {{VectorAt(record.move(), 0), record.move(3)},
                  {VectorAt(record.move(), 4), record.move(7)}};
  }
  event.before = BeliefFromProto(record.before());
  event.after = BeliefFromProto(record.after());
  event.related = ObjectId{record.related()};
  event.supporting_frames = record.views();
  event.contradicted_updates = record.absences();
  event.source = {record.robot(), record.sensor()};
  return event;
}

storage::v1::FreeBlockRecord ToProto(const FreeBlock& block) {
  storage::v1::FreeBlockRecord record;
  for (const std::uint64_t word : block.cells) record.add_cells(word);
  record.set_recent_since_ns(block.recent_since.nanoseconds());
  if (block.recent == LeafMask{}) return record;
  for (const std::uint64_t word : block.recent) record.add_recent(word);
  return record;
}

absl::StatusOr<FreeBlock> FromProto(const storage::v1::FreeBlockRecord& record) {
  FreeBlock block;
  if (record.cells_size() != static_cast<int>(block.cells.size()) ||
      (record.recent_size() != 0 &&
       record.recent_size() != static_cast<int>(block.recent.size()))) {
    return CorruptRecord("a free-space record does not contain a valid block");
  }
  std::copy(record.cells().begin(), record.cells().end(), block.cells.begin());
  std::copy(record.recent().begin(), record.recent().end(), block.recent.begin());
  block.recent_since = Timestamp::FromNanoseconds(record.recent_since_ns());
  for (std::size_t x = 0; x < block.cells.size(); ++x) {
    if ((block.recent[x] & ~block.cells[x]) != 0) {
      return CorruptRecord("a free-space record has a recent cell that was never free");
    }
  }
  return block;
}

}  // namespace steadymap
