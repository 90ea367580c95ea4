#pragma once

#include <string_view>

#include <absl/status/statusor.h>

#include "core/map/object_event.h"
#include "core/types/identifiers.h"

#include "steadymap/v1/event.pb.h"

/// The border between the wire and core: a map's history. What comes in is checked; field paths in
/// errors are relative to the message. Pure functions, any thread.
namespace steadymap {

/// Errors: `InvalidArgument` with reason `BAD_VALUE` and `field` for a type that is unknown or not
/// given.
absl::StatusOr<EventType> ReadEventType(v1::EventType type, std::string_view field);
v1::EventType ToProto(EventType type);

/// An event without its number. Errors: `InvalidArgument` with reason `BAD_VALUE` for number 0, an
/// unknown type or reason, a class that is out of range, points that are absent or not finite, a
/// confidence outside [0, 1], a robot that is no valid id, and as for `v1::Belief`, which may be
/// absent for events of robots alone; `BAD_TIMESTAMP` for a time out of range.
absl::StatusOr<ObjectEvent> FromProto(const v1::ObjectEvent& message);
v1::ObjectEvent ToProto(EventNumber number, const ObjectEvent& event);

}  // namespace steadymap
