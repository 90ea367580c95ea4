#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/types/timestamp.h"

#include "google/protobuf/timestamp.pb.h"
#include "steadymap/v1/geometry.pb.h"

/// Conversion between messages and core types: vectors, poses, boxes and timestamps. FromProto
/// checks every field, vectors excepted; field paths in errors are relative to the message. Pure
/// functions, any thread.
namespace steadymap {

/// Copies the components without a check, NaN included; the valid range depends on the field.
Eigen::Vector3d FromProto(const v1::Vector3& message);
v1::Vector3 ToProto(const Eigen::Vector3d& vector);

/// A transform `T_destination_source`. Errors: those of `MakePose`, with the field `position_m` or
/// `orientation`, also if the field is absent.
absl::StatusOr<Eigen::Isometry3d> FromProto(const v1::Pose& message);
v1::Pose ToProto(const Eigen::Isometry3d& transform);

/// A box. Errors: `InvalidArgument` with reason `BAD_VALUE` and the field `min_m` or `max_m` for a
/// corner that is absent or not finite, and for a maximum below the minimum.
absl::StatusOr<Box> FromProto(const v1::Box& message);

/// The message of a box, which must not be empty.
v1::Box ToProto(const Box& box);

/// A time. Errors: `InvalidArgument` with reason `BAD_TIMESTAMP` and the field `seconds` or `nanos`
/// for times before 1970 or after 2261, and nanoseconds outside [0, 999 999 999].
absl::StatusOr<Timestamp> FromProto(const google::protobuf::Timestamp& message);

/// The message of a time, which must not be before 1970.
google::protobuf::Timestamp ToProto(Timestamp time);

}  // namespace steadymap
