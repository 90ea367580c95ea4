#include "proto/convert_geometry.h"

#include <cstdint>
#include <limits>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

// One second below the last whole second, so that any number of nanoseconds can be added.
constexpr std::int64_t kMaxSeconds =
    std::numeric_limits<std::int64_t>::max() / kNanosecondsPerSecond - 1;

absl::Status CheckCorner(const char* field, bool present, const Eigen::Vector3d& corner) {
  if (!present) {
    return InvalidField(
        reason::kBadValue, field, absl::StrCat("a box needs its corner ", field, ", it is absent"));
  }
  if (corner.allFinite()) return absl::OkStatus();
  return InvalidField(
      reason::kBadValue,
      field,
      absl::StrCat(
          field, " must be finite, got (", corner.x(), ", ", corner.y(), ", ", corner.z(), ")"));
}

}  // namespace

Eigen::Vector3d FromProto(const v1::Vector3& message) {
  return {message.x(), message.y(), message.z()};
}

v1::Vector3 ToProto(const Eigen::Vector3d& vector) {
  v1::Vector3 message;
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
  return message;
}

absl::StatusOr<Eigen::Isometry3d> FromProto(const v1::Pose& message) {
  // An absent position is an error of the client, not the origin. MakePose refuses an absent
  // orientation, because its norm is 0.
  if (!message.has_position_m()) {
    return InvalidField(
        reason::kNonFinitePose, "position_m", "a pose needs its position, it is absent");
  }
  const v1::Quaternion& orientation = message.orientation();
  return MakePose(
      FromProto(message.position_m()),
      Eigen::Vector4d(orientation.x(), orientation.y(), orientation.z(), orientation.w()));
}

v1::Pose ToProto(const Eigen::Isometry3d& transform) {
  const Eigen::Quaterniond rotation(transform.linear());
  v1::Pose message;
  *message.mutable_position_m() = ToProto(Eigen::Vector3d(transform.translation()));
  message.mutable_orientation()->set_x(rotation.x());
  message.mutable_orientation()->set_y(rotation.y());
  message.mutable_orientation()->set_z(rotation.z());
  message.mutable_orientation()->set_w(rotation.w());
  return message;
}

absl::StatusOr<Box> FromProto(const v1::Box& message) {
  const Eigen::Vector3d low = FromProto(message.min_m());
  const Eigen::Vector3d high = FromProto(message.max_m());
  if (absl::Status status = CheckCorner("min_m", message.has_min_m(), low); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckCorner("max_m", message.has_max_m(), high); !status.ok()) {
    return status;
  }
  if ((low.array() > high.array()).any()) {
    return InvalidField(
        reason::kBadValue, "max_m", "no coordinate of max_m may lie below that of min_m");
  }
  return Box(low, high);
}

v1::Box ToProto(const Box& box) {
  v1::Box message;
  *message.mutable_min_m() = ToProto(box.min());
  *message.mutable_max_m() = ToProto(box.max());
  return message;
}

absl::StatusOr<Timestamp> FromProto(const google::protobuf::Timestamp& message) {
  if (message.seconds() < 0 || message.seconds() > kMaxSeconds) {
    return InvalidField(
        reason::kBadTimestamp,
        "seconds",
        absl::StrCat(
            "seconds since 1970 must lie in [0, ", kMaxSeconds, "], got ", message.seconds()));
  }
  if (message.nanos() < 0 || message.nanos() >= kNanosecondsPerSecond) {
    return InvalidField(
        reason::kBadTimestamp,
        "nanos",
        absl::StrCat("nanoseconds must lie in [0, 999999999], got ", message.nanos()));
  }
  return Timestamp::FromNanoseconds(message.seconds() * kNanosecondsPerSecond + message.nanos());
}

google::protobuf::Timestamp ToProto(Timestamp time) {
  google::protobuf::Timestamp message;
  message.set_seconds(time.nanoseconds() / kNanosecondsPerSecond);
  message.set_nanos(static_cast<std::int32_t>(time.nanoseconds() % kNanosecondsPerSecond));
  return message;
}

}  // namespace steadymap
