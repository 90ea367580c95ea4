#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "core/map/object_event.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/event.pb.h"

/// Conversion between messages and core types: events. FromProto checks every field; field paths in
/// errors are relative to the message. Pure functions, any thread.
namespace steadymap {

/// The event type of a request. Errors: `InvalidArgument` with reason `BAD_VALUE` and `field` for
/// an unknown or unspecified type.
absl::StatusOr<EventType> ReadEventType(v1::EventType type, std::string_view field);
v1::EventType ToProto(EventType type);

/// An event without its number. Errors: `InvalidArgument` with reason `BAD_VALUE` for number 0, an
/// unknown type or reason, a class out of range, an absent centre, a point that is not finite, a
/// confidence outside [0, 1], an invalid robot or sensor id, an invalid pose, and an invalid belief
/// (only robot events may have none); `BAD_TIMESTAMP` for a time out of range.
absl::StatusOr<ObjectEvent> FromProto(const v1::ObjectEvent& message);
v1::ObjectEvent ToProto(EventNumber number, const ObjectEvent& event);

}  // namespace steadymap
