#include "proto/convert_event.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/convert_geometry.h"
#include "proto/convert_object.h"

namespace steadymap {
namespace {

constexpr std::array<std::pair<EventType, v1::EventType>, 10> kTypes = {{
    {EventType::kCreated, v1::EVENT_TYPE_CREATED},
    {EventType::kUpdated, v1::EVENT_TYPE_UPDATED},
    {EventType::kMoved, v1::EVENT_TYPE_MOVED},
    {EventType::kRemoved, v1::EVENT_TYPE_REMOVED},
    {EventType::kReturned, v1::EVENT_TYPE_RETURNED},
    {EventType::kMerged, v1::EVENT_TYPE_MERGED},
    {EventType::kSplit, v1::EVENT_TYPE_SPLIT},
    {EventType::kRobotLost, v1::EVENT_TYPE_ROBOT_LOST},
    {EventType::kRobotFound, v1::EVENT_TYPE_ROBOT_FOUND},
    {EventType::kContradicted, v1::EVENT_TYPE_CONTRADICTED},
}};

constexpr std::array<std::pair<EventReason, v1::EventReason>, 9> kReasons = {{
    {EventReason::kNewSurface, v1::EVENT_REASON_NEW_SURFACE},
    {EventReason::kSeenThrough, v1::EVENT_REASON_SEEN_THROUGH},
    {EventReason::kDisplaced, v1::EVENT_REASON_DISPLACED},
    {EventReason::kReplaced, v1::EVENT_REASON_REPLACED},
    {EventReason::kShapeMatched, v1::EVENT_REASON_SHAPE_MATCHED},
    {EventReason::kConnected, v1::EVENT_REASON_CONNECTED},
    {EventReason::kDisconnected, v1::EVENT_REASON_DISCONNECTED},
    {EventReason::kDisagreement, v1::EVENT_REASON_DISAGREEMENT},
    {EventReason::kAgreement, v1::EVENT_REASON_AGREEMENT},
}};

absl::StatusOr<EventReason> ReadReason(v1::EventReason wire) {
  for (const auto& [known, message] : kReasons) {
    if (message == wire) return known;
  }
  return InvalidField(
      reason::kBadValue,
      "reason",
      absl::StrCat("the reason must be one that is known, got ", static_cast<int>(wire)));
}

v1::EventReason ReasonToProto(EventReason known) {
  for (const auto& [candidate, message] : kReasons) {
    if (candidate == known) return message;
  }
  return v1::EVENT_REASON_UNSPECIFIED;
}

bool IsAboutRobot(EventType type) {
  return type == EventType::kRobotLost || type == EventType::kRobotFound;
}

absl::StatusOr<Eigen::Vector3d> ReadPoint(const char* field, const v1::Vector3& message) {
  const Eigen::Vector3d point = FromProto(message);
  if (point.allFinite()) return point;
  return InvalidField(reason::kBadValue, field, absl::StrCat(field, " must be finite"));
}

/// Reads the beliefs before and after an event; robot events may have none.
absl::Status ReadBeliefs(const v1::ObjectEvent& message, ObjectEvent* event) {
  const bool optional = IsAboutRobot(event->type);
  if (!optional || message.has_before()) {
    const absl::StatusOr<Belief> before = FromProto(message.before());
    if (!before.ok()) return WithFieldPrefix(before.status(), "before");
    event->before = *before;
  }
  if (!optional || message.has_after()) {
    const absl::StatusOr<Belief> after = FromProto(message.after());
    if (!after.ok()) return WithFieldPrefix(after.status(), "after");
    event->after = *after;
  }
  return absl::OkStatus();
}

absl::Status ReadMove(const v1::ObjectEvent& message, ObjectEvent* event) {
  if (!message.has_world_from_object_before() && !message.has_world_from_object_after()) {
    return absl::OkStatus();
  }
  const absl::StatusOr<UprightPose> before = FromProto(message.world_from_object_before());
  if (!before.ok()) return WithFieldPrefix(before.status(), "world_from_object_before");
  const absl::StatusOr<UprightPose> after = FromProto(message.world_from_object_after());
  if (!after.ok()) return WithFieldPrefix(after.status(), "world_from_object_after");
  event->move = {*before, *after};
  return absl::OkStatus();
}

/// Reads the places of an event and the confidence of a move.
absl::Status ReadPlaces(const v1::ObjectEvent& message, ObjectEvent* event) {
  if (!message.has_center_m()) {
    return InvalidField(reason::kBadValue, "center_m", "center_m is absent");
  }
  const absl::StatusOr<Eigen::Vector3d> center = ReadPoint("center_m", message.center_m());
  if (!center.ok()) return center.status();
  event->center_world = *center;
  if (message.has_old_center_m()) {
    const absl::StatusOr<Eigen::Vector3d> old_center =
        ReadPoint("old_center_m", message.old_center_m());
    if (!old_center.ok()) return old_center.status();
    event->old_center_world = *old_center;
  }
  if (absl::Status status = ReadMove(message, event); !status.ok()) return status;
  if (!message.has_confidence()) return absl::OkStatus();
  event->confidence = message.confidence();
  // NaN fails the comparison.
  if (message.confidence() >= 0.0 && message.confidence() <= 1.0) return absl::OkStatus();
  return InvalidField(reason::kBadValue,
                      "confidence",
                      absl::StrCat("confidence must lie in [0, 1], got ", message.confidence()));
}

}  // namespace

absl::StatusOr<EventType> ReadEventType(v1::EventType type, std::string_view field) {
  for (const auto& [known, message] : kTypes) {
    if (message == type) return known;
  }
  return InvalidField(
      reason::kBadValue,
      field,
      absl::StrCat("the type must be one that is known, got ", static_cast<int>(type)));
}

v1::EventType ToProto(EventType type) {
  for (const auto& [candidate, message] : kTypes) {
    if (candidate == type) return message;
  }
  return v1::EVENT_TYPE_UNSPECIFIED;
}

absl::StatusOr<ObjectEvent> FromProto(const v1::ObjectEvent& message) {
  if (message.number() == 0) {
    return InvalidField(reason::kBadValue, "number", "an event's number must be above 0");
  }
  ObjectEvent event;
  const absl::StatusOr<EventType> type = ReadEventType(message.type(), "type");
  if (!type.ok()) return type.status();
  event.type = *type;
  const absl::StatusOr<EventReason> why = ReadReason(message.reason());
  if (!why.ok()) return why.status();
  event.reason = *why;
  if (message.class_id() > std::numeric_limits<std::uint16_t>::max()) {
    return InvalidField(reason::kBadValue,
                        "class_id",
                        absl::StrCat("a class id must be below 65536, got ", message.class_id()));
  }
  event.class_id = ClassId(static_cast<std::uint16_t>(message.class_id()));
  const absl::StatusOr<Timestamp> time = FromProto(message.capture_time());
  if (!time.ok()) return WithFieldPrefix(time.status(), "capture_time");
  event.time = *time;
  absl::Status status = ReadPlaces(message, &event);
  if (status.ok()) status = ReadBeliefs(message, &event);
  if (!status.ok()) return status;
  const bool is_named = !message.robot().empty() || !message.sensor().empty();
  if (is_named && (!IsValidId(message.robot()) || !IsValidId(message.sensor()))) {
    return InvalidField(reason::kBadValue, "robot", "robot must be empty or an id");
  }
  event.object = ObjectId(message.object_id());
  event.related = ObjectId(message.related_object_id());
  event.revision = Revision(message.revision());
  event.supporting_frames = message.views();
  event.contradicted_updates = message.absences();
  event.source = {message.robot(), message.sensor()};
  return event;
}

v1::ObjectEvent ToProto(EventNumber number, const ObjectEvent& event) {
  v1::ObjectEvent message;
  message.set_number(number.value());
  message.set_type(ToProto(event.type));
  message.set_reason(ReasonToProto(event.reason));
  message.set_object_id(event.object.value());
  message.set_class_id(event.class_id.value());
  *message.mutable_capture_time() = ToProto(event.time);
  message.set_revision(event.revision.value());
  *message.mutable_center_m() = ToProto(event.center_world);
  if (event.old_center_world) *message.mutable_old_center_m() = ToProto(*event.old_center_world);
  if (event.confidence) message.set_confidence(*event.confidence);
  if (event.move) {
    *message.mutable_world_from_object_before() = ToProto(event.move->T_world_before);
    *message.mutable_world_from_object_after() = ToProto(event.move->T_world_after);
  }
  if (!IsAboutRobot(event.type)) {
    *message.mutable_before() = ToProto(event.before);
    *message.mutable_after() = ToProto(event.after);
  }
  message.set_related_object_id(event.related.value());
  message.set_views(event.supporting_frames);
  message.set_absences(event.contradicted_updates);
  message.set_robot(event.source.robot);
  message.set_sensor(event.source.sensor);
  return message;
}

}  // namespace steadymap
