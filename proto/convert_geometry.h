#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/geometry/geometry.h"
#include "core/types/timestamp.h"

#include "google/protobuf/timestamp.pb.h"
#include "steadymap/v1/geometry.pb.h"

/// The border between the wire and core, part one: vectors, poses, boxes and moments. Everything
/// that comes in is checked. Field paths in errors are relative to the message. Pure functions, any
/// thread.
namespace steadymap {

/// Copies the components as they are, NaN included: what is allowed depends on the field.
Eigen::Vector3d FromProto(const v1::Vector3& message);
v1::Vector3 ToProto(const Eigen::Vector3d& vector);

/// A `T_destination_source`. Errors: as `MakePose`, with the fields `position_m` and `orientation`;
/// an absent part is an error of that part.
absl::StatusOr<Eigen::Isometry3d> FromProto(const v1::Pose& message);
v1::Pose ToProto(const Eigen::Isometry3d& transform);

/// Errors: `InvalidArgument` with reason `BAD_VALUE` and the field `min_m` or `max_m` for a corner
/// that is absent or not finite, and for a maximum below the minimum.
absl::StatusOr<Box> FromProto(const v1::Box& message);

/// `box` must not be empty.
v1::Box ToProto(const Box& box);

/// Errors: `InvalidArgument` with reason `BAD_TIMESTAMP` and the field `seconds` or `nanos` for
/// moments before 1970 or after 2261, and nanoseconds outside [0, 999 999 999].
absl::StatusOr<Timestamp> FromProto(const google::protobuf::Timestamp& message);

/// `time` must not lie before 1970.
google::protobuf::Timestamp ToProto(Timestamp time);

}  // namespace steadymap
