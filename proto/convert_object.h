#pragma once

#include <absl/status/statusor.h>

#include "core/map/map_object.h"

#include "steadymap/v1/object.pb.h"

/// Conversion between messages and core types: objects and beliefs. FromProto checks every field;
/// field paths in errors are relative to the message. Pure functions, any thread.
namespace steadymap {

/// A belief. Errors: `InvalidArgument` with reason `BAD_VALUE` for numbers that are not finite, and
/// for a standard deviation, alpha or beta that is not above 0.
absl::StatusOr<Belief> FromProto(const v1::Belief& message);
v1::Belief ToProto(const Belief& belief);

/// An upright pose. Errors: `InvalidArgument` with reason `BAD_VALUE` for an absent position,
/// numbers that are not finite, and a coordinate further than `kMaxPositionM` from the origin.
absl::StatusOr<UprightPose> FromProto(const v1::UprightPose& message);
v1::UprightPose ToProto(const UprightPose& pose);

/// A cuboid. Errors: `InvalidArgument` with reason `BAD_VALUE` for an absent centre or size,
/// numbers that are not finite, and negative sides.
absl::StatusOr<Cuboid> FromProto(const v1::Cuboid& message);
v1::Cuboid ToProto(const Cuboid& cuboid);

/// The state of an object. The message has no evidence of single leaves and no `standing_since`;
/// they keep the values of a new object. Derived fields are not read.
/// Errors: those of the functions above, and `BAD_VALUE` for id 0, an unknown standing, a class out
/// of range, votes out of order, and negative counts; `BAD_TIMESTAMP` for times out of range.
absl::StatusOr<ObjectState> FromProto(const v1::Object& message);

/// The message of an object with all its public fields.
v1::Object ToProto(const MapObject& object);

}  // namespace steadymap
