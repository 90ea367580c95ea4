#include "proto/convert_object.h"

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/geometry/geometry.h"
#include "core/types/error.h"
#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

/// A number of a message, with its field name for errors. NaN fails every comparison below.
struct CheckedNumber {
  const char* field;
  double value;
};

absl::Status CheckFinite(std::initializer_list<CheckedNumber> numbers) {
  for (const CheckedNumber& number : numbers) {
    if (std::isfinite(number.value)) continue;
    return InvalidField(reason::kBadValue,
                        number.field,
                        absl::StrCat(number.field, " must be finite, got ", number.value));
  }
  return absl::OkStatus();
}

absl::Status CheckPositive(std::initializer_list<CheckedNumber> numbers) {
  for (const CheckedNumber& number : numbers) {
    if (std::isfinite(number.value) && number.value > 0.0) continue;
    return InvalidField(
        reason::kBadValue,
        number.field,
        absl::StrCat(number.field, " must be finite and above 0, got ", number.value));
  }
  return absl::OkStatus();
}

absl::Status CheckNotNegative(std::initializer_list<CheckedNumber> numbers) {
  for (const CheckedNumber& number : numbers) {
    if (std::isfinite(number.value) && number.value >= 0.0) continue;
    return InvalidField(
        reason::kBadValue,
        number.field,
        absl::StrCat(number.field, " must be finite and at least 0, got ", number.value));
  }
  return absl::OkStatus();
}

/// Refuses an absent vector: its absence is an error of the sender, not the origin.
absl::Status CheckVector(const char* field, bool present, const Eigen::Vector3d& vector) {
  if (!present) return InvalidField(reason::kBadValue, field, absl::StrCat(field, " is absent"));
  return CheckFinite({{field, vector.x()}, {field, vector.y()}, {field, vector.z()}});
}

absl::StatusOr<ClassId> ReadClass(std::uint32_t class_id) {
  if (class_id <= std::numeric_limits<std::uint16_t>::max()) {
    return ClassId(static_cast<std::uint16_t>(class_id));
  }
  return InvalidField(reason::kBadValue,
                      "class_id",
                      absl::StrCat("a class id must be below 65536, got ", class_id));
}

absl::StatusOr<ObjectStatus> ReadStanding(v1::ObjectStanding standing) {
  switch (standing) {
    case v1::OBJECT_STANDING_TENTATIVE:
      return ObjectStatus::kTentative;
    case v1::OBJECT_STANDING_PRESENT:
      return ObjectStatus::kPresent;
    case v1::OBJECT_STANDING_ARCHIVED:
      return ObjectStatus::kArchived;
    default:
      return InvalidField(
          reason::kBadValue,
          "standing",
          absl::StrCat("the standing must be one that is known, got ", static_cast<int>(standing)));
  }
}

v1::ObjectStanding StandingToProto(ObjectStatus standing) {
  switch (standing) {
    case ObjectStatus::kTentative:
      return v1::OBJECT_STANDING_TENTATIVE;
    case ObjectStatus::kPresent:
      return v1::OBJECT_STANDING_PRESENT;
    case ObjectStatus::kArchived:
      return v1::OBJECT_STANDING_ARCHIVED;
  }
  return v1::OBJECT_STANDING_UNSPECIFIED;
}

absl::StatusOr<std::vector<ClassVote>> ReadVotes(const v1::Object& message) {
  std::vector<ClassVote> votes;
  votes.reserve(static_cast<std::size_t>(message.votes_size()));
  for (int i = 0; i < message.votes_size(); ++i) {
    const std::string path = absl::StrCat("votes[", i, "]");
    const absl::StatusOr<ClassId> class_id = ReadClass(message.votes(i).class_id());
    if (!class_id.ok()) return WithFieldPrefix(class_id.status(), path);
    if (!votes.empty() && *class_id <= votes.back().class_id) {
      return InvalidField(reason::kBadValue, path + ".class_id", "votes must come by rising class");
    }
    const double weight = message.votes(i).weight();
    if (absl::Status status = CheckNotNegative({{"weight", weight}}); !status.ok()) {
      return WithFieldPrefix(status, path);
    }
    votes.push_back({*class_id, weight});
  }
  return votes;
}

/// Reads the fields of message type.
absl::Status ReadParts(const v1::Object& message, ObjectState* object) {
  const absl::StatusOr<Cuboid> cuboid = FromProto(message.cuboid());
  if (!cuboid.ok()) return WithFieldPrefix(cuboid.status(), "cuboid");
  const absl::StatusOr<UprightPose> pose = FromProto(message.world_from_object());
  if (!pose.ok()) return WithFieldPrefix(pose.status(), "world_from_object");
  const absl::StatusOr<Belief> belief = FromProto(message.belief());
  if (!belief.ok()) return WithFieldPrefix(belief.status(), "belief");
  const absl::StatusOr<Timestamp> first_seen = FromProto(message.first_seen());
  if (!first_seen.ok()) return WithFieldPrefix(first_seen.status(), "first_seen");
  const absl::StatusOr<Timestamp> last_seen = FromProto(message.last_seen());
  if (!last_seen.ok()) return WithFieldPrefix(last_seen.status(), "last_seen");
  object->cuboid = *cuboid;
  object->T_world_object = *pose;
  object->belief = *belief;
  object->first_seen = *first_seen;
  object->last_seen = *last_seen;
  return absl::OkStatus();
}

v1::Contradiction ContradictionToProto(const Contradiction& contradiction) {
  v1::Contradiction message;
  message.set_present_robot(contradiction.present.robot);
  message.set_present_sensor(contradiction.present.sensor);
  message.set_absent_robot(contradiction.absent.robot);
  message.set_absent_sensor(contradiction.absent.sensor);
  *message.mutable_since() = ToProto(contradiction.since);
  *message.mutable_last() = ToProto(contradiction.last);
  message.set_sessions(contradiction.sessions);
  return message;
}

absl::StatusOr<Contradiction> ReadContradiction(const v1::Contradiction& message) {
  const absl::StatusOr<Timestamp> since = FromProto(message.since());
  if (!since.ok()) return WithFieldPrefix(since.status(), "since");
  const absl::StatusOr<Timestamp> last = FromProto(message.last());
  if (!last.ok()) return WithFieldPrefix(last.status(), "last");
  return Contradiction{.absent = {message.absent_robot(), message.absent_sensor()},
                       .present = {message.present_robot(), message.present_sensor()},
                       .since = *since,
                       .last = *last,
                       .sessions = message.sessions()};
}

absl::Status ReadContradictions(const v1::Object& message, ObjectState* object) {
  for (int i = 0; i < message.contradictions_size(); ++i) {
    absl::StatusOr<Contradiction> read = ReadContradiction(message.contradictions(i));
    if (!read.ok()) {
      return WithFieldPrefix(read.status(), absl::StrCat("contradictions[", i, "]"));
    }
    object->contradictions.push_back(*std::move(read));
  }
  return absl::OkStatus();
}

/// Share of the object's class in all votes; 0 without votes.
double ClassConfidence(const ObjectState& object) {
  double all = 0.0;
  double winner = 0.0;
  for (const ClassVote& vote : object.votes) {
    all += vote.weight;
    if (vote.class_id == object.class_id) winner = vote.weight;
  }
  return all > 0.0 ? winner / all : 0.0;
}

}  // namespace

absl::StatusOr<UprightPose> FromProto(const v1::UprightPose& message) {
  const UprightPose pose{FromProto(message.position_m()), message.yaw_rad()};
  absl::Status status = CheckVector("position_m", message.has_position_m(), pose.position_world);
  if (status.ok()) status = CheckFinite({{"yaw_rad", pose.yaw_rad}});
  if (!status.ok()) return status;
  if ((pose.position_world.array().abs() > kMaxPositionM).any()) {
    return InvalidField(
        reason::kBadValue,
        "position_m",
        absl::StrCat("position_m must lie within ", kMaxPositionM, " m of the origin"));
  }
  return pose;
}

v1::UprightPose ToProto(const UprightPose& pose) {
  v1::UprightPose message;
  *message.mutable_position_m() = ToProto(pose.position_world);
  message.set_yaw_rad(pose.yaw_rad);
  return message;
}

absl::StatusOr<Belief> FromProto(const v1::Belief& message) {
  absl::Status status = CheckFinite({{"change_mean_m", message.change_mean_m()}});
  if (!status.ok()) return status;
  status = CheckPositive({{"change_std_m", message.change_std_m()},
                          {"alpha", message.alpha()},
                          {"beta", message.beta()}});
  if (!status.ok()) return status;
  return Belief{message.change_mean_m(), message.change_std_m(), message.alpha(), message.beta()};
}

v1::Belief ToProto(const Belief& belief) {
  v1::Belief message;
  message.set_change_mean_m(belief.change_mean_m);
  message.set_change_std_m(belief.change_std_m);
  message.set_alpha(belief.alpha);
  message.set_beta(belief.beta);
  return message;
}

absl::StatusOr<Cuboid> FromProto(const v1::Cuboid& message) {
  const Cuboid cuboid{
      FromProto(message.center_m()), FromProto(message.size_m()), message.yaw_rad()};
  absl::Status status = CheckVector("center_m", message.has_center_m(), cuboid.center_world);
  if (!status.ok()) return status;
  status = CheckVector("size_m", message.has_size_m(), cuboid.size_m);
  if (!status.ok()) return status;
  status = CheckNotNegative({{"size_m", cuboid.size_m.minCoeff()}});
  if (!status.ok()) return status;
  status = CheckFinite({{"yaw_rad", cuboid.yaw_rad}});
  if (!status.ok()) return status;
  return cuboid;
}

v1::Cuboid ToProto(const Cuboid& cuboid) {
  v1::Cuboid message;
  *message.mutable_center_m() = ToProto(cuboid.center_world);
  *message.mutable_size_m() = ToProto(cuboid.size_m);
  message.set_yaw_rad(cuboid.yaw_rad);
  return message;
}

absl::StatusOr<ObjectState> FromProto(const v1::Object& message) {
  ObjectState object;
  object.id = ObjectId(message.id());
  if (object.id == kBackgroundId) {
    return InvalidField(reason::kBadValue, "id", "an object's id must be above 0");
  }
  const absl::StatusOr<ObjectStatus> standing = ReadStanding(message.standing());
  if (!standing.ok()) return standing.status();
  object.status = *standing;
  const absl::StatusOr<ClassId> class_id = ReadClass(message.class_id());
  if (!class_id.ok()) return class_id.status();
  object.class_id = *class_id;
  absl::StatusOr<std::vector<ClassVote>> votes = ReadVotes(message);
  if (!votes.ok()) return votes.status();
  object.votes = *std::move(votes);
  absl::Status status = ReadParts(message, &object);
  if (status.ok()) status = ReadContradictions(message, &object);
  if (!status.ok()) return status;
  status = CheckNotNegative(
      {{"present_cells", message.present_cells()}, {"absent_cells", message.absent_cells()}});
  if (!status.ok()) return status;
  object.evidence.present_cells = message.present_cells();
  object.evidence.absent_cells = message.absent_cells();
  object.supporting_frames = message.views();
  object.contradicted_updates = message.absences();
  object.revision = Revision(message.revision());
  return object;
}

v1::Object ToProto(const MapObject& object) {
  v1::Object message;
  message.set_id(object.id.value());
  message.set_standing(StandingToProto(object.status));
  message.set_class_id(object.class_id.value());
  message.set_class_confidence(ClassConfidence(object));
  for (const ClassVote& vote : object.votes) {
    v1::ClassVote* added = message.add_votes();
    added->set_class_id(vote.class_id.value());
    added->set_weight(vote.weight);
  }
  *message.mutable_cuboid() = ToProto(object.cuboid);
  *message.mutable_world_from_object() = ToProto(object.T_world_object);
  *message.mutable_belief() = ToProto(object.belief);
  message.set_stationarity(object.belief.stationarity());
  *message.mutable_first_seen() = ToProto(object.first_seen);
  *message.mutable_last_seen() = ToProto(object.last_seen);
  message.set_views(object.supporting_frames);
  message.set_absences(object.contradicted_updates);
  message.set_present_cells(object.evidence.present_cells);
  message.set_absent_cells(object.evidence.absent_cells);
  message.set_revision(object.revision.value());
  if (object.volume != nullptr) message.set_leaves(object.volume->leaf_count());
  for (const Contradiction& contradiction : object.contradictions) {
    if (contradiction.is_confirmed()) {
      *message.add_contradictions() = ContradictionToProto(contradiction);
    }
  }
  return message;
}

}  // namespace steadymap
