#pragma once

#include <absl/status/statusor.h>

#include "core/map/map_object.h"

#include "steadymap/v1/object.pb.h"

/// The border between the wire and core: objects and what is believed of them. What comes in is
/// checked; field paths in errors are relative to the message. Pure functions, any thread.
namespace steadymap {

/// Errors: `InvalidArgument` with reason `BAD_VALUE` for numbers that are not finite, and for a
/// standard deviation, alpha or beta that is not above 0.
absl::StatusOr<Belief> FromProto(const v1::Belief& message);
v1::Belief ToProto(const Belief& belief);

/// Errors: `InvalidArgument` with reason `BAD_VALUE` for a pose that is absent, not finite, or
/// further than `kMaxPositionM` from the origin.
absl::StatusOr<UprightPose> FromProto(const v1::UprightPose& message);
v1::UprightPose ToProto(const UprightPose& pose);

/// Errors: `InvalidArgument` with reason `BAD_VALUE` for numbers that are not finite and sides
/// below 0; an absent part is an error of that part.
absl::StatusOr<Cuboid> FromProto(const v1::Cuboid& message);
v1::Cuboid ToProto(const Cuboid& cuboid);

/// The state of an object. What the wire leaves out stays as it is in a new object: the evidence of
/// single leaves. Fields that follow from others are not read.
/// Errors: as above, and `BAD_VALUE` for id 0, an unknown standing, a class that is out of range,
/// votes out of order, a pose that is not finite or too far away, and counts that are negative;
/// `BAD_TIMESTAMP` for times out of range.
absl::StatusOr<ObjectState> FromProto(const v1::Object& message);

/// The object with everything a reader may know of it.
v1::Object ToProto(const MapObject& object);

}  // namespace steadymap
