#include "proto/convert_robot.h"

#include "proto/convert_geometry.h"

namespace steadymap {
namespace {

v1::RobotTrust ToProto(Trust trust) {
  switch (trust) {
    case Trust::kTrusted:
      return v1::ROBOT_TRUST_TRUSTED;
    case Trust::kDoubted:
      return v1::ROBOT_TRUST_DOUBTED;
    case Trust::kLost:
      return v1::ROBOT_TRUST_LOST;
  }
  return v1::ROBOT_TRUST_UNSPECIFIED;
}

v1::PoseOffset ToProto(const PoseOffset& offset) {
  v1::PoseOffset message;
  *message.mutable_time() = steadymap::ToProto(offset.time);
  *message.mutable_center_m() = steadymap::ToProto(offset.center_world);
  *message.mutable_shift_m() = steadymap::ToProto(offset.shift_world);
  message.set_yaw_rad(offset.yaw_rad);
  for (const double number : offset.covariance.reshaped<Eigen::RowMajor>()) {
    message.add_covariance(number);
  }
  message.set_anchors(offset.anchors);
  return message;
}

v1::PoseError ToProto(const PoseErrorEstimate& estimate) {
  const PoseError error = estimate.Combined();
  v1::PoseError message;
  *message.mutable_time() = steadymap::ToProto(estimate.time);
  *message.mutable_shift_m() = steadymap::ToProto(Eigen::Vector3d(error.mean.head<3>()));
  *message.mutable_rotation_rad() = steadymap::ToProto(Eigen::Vector3d(error.mean.tail<3>()));
  for (const double number : error.covariance.reshaped<Eigen::RowMajor>()) {
    message.add_covariance(number);
  }
  return message;
}

}  // namespace

v1::Robot ToProto(const SensorName& name, const RobotState& state) {
  v1::Robot message;
  message.set_robot(name.robot);
  message.set_sensor(name.sensor);
  message.set_trust(ToProto(state.trust));
  *message.mutable_last_capture_time() = ToProto(state.last_capture_time);
  *message.mutable_world_from_camera() = ToProto(state.claimed.ToIsometry());
  if (state.session_start) *message.mutable_session_start() = ToProto(*state.session_start);
  if (state.offset) *message.mutable_pose_offset() = ToProto(*state.offset);
  if (state.pose_error) *message.mutable_pose_error() = ToProto(*state.pose_error);
  return message;
}

v1::SensorContradiction ToProto(const SensorContradiction& contradiction) {
  v1::SensorContradiction message;
  message.set_robot(contradiction.other.robot);
  message.set_sensor(contradiction.other.sensor);
  message.set_objects(contradiction.objects);
  *message.mutable_since() = ToProto(contradiction.since);
  return message;
}

}  // namespace steadymap
