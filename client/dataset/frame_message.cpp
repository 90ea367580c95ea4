#include "client/dataset/frame_message.h"

namespace steadymap {
void FillFrameMessage(Timestamp capture_time,
                      const PinholeCamera& camera,
                      const Eigen::Isometry3d& T_world_camera,
                      v1::Frame* message) {
  // The nanoseconds of a protobuf timestamp are never negative, even before 1970.
  const std::int64_t ns = capture_time.nanoseconds();
  const std::int64_t nanos =
      ((ns % kNanosecondsPerSecond) + kNanosecondsPerSecond) % kNanosecondsPerSecond;
  message->mutable_capture_time()->set_seconds((ns - nanos) / kNanosecondsPerSecond);
  message->mutable_capture_time()->set_nanos(static_cast<std::int32_t>(nanos));

  v1::CameraIntrinsics* intrinsics = message->mutable_intrinsics();
  intrinsics->set_width_px(static_cast<std::uint32_t>(camera.width_px));
  intrinsics->set_height_px(static_cast<std::uint32_t>(camera.height_px));
  intrinsics->set_fx(camera.fx);
  intrinsics->set_fy(camera.fy);
  intrinsics->set_cx(camera.cx);
  intrinsics->set_cy(camera.cy);

  const Eigen::Vector3d position = T_world_camera.translation();
  const Eigen::Quaterniond rotation(T_world_camera.linear());
  v1::Vector3* position_m = message->mutable_world_from_camera()->mutable_position_m();
  position_m->set_x(position.x());
  position_m->set_y(position.y());
  position_m->set_z(position.z());
  v1::Quaternion* orientation = message->mutable_world_from_camera()->mutable_orientation();
  orientation->set_x(rotation.x());
  orientation->set_y(rotation.y());
  orientation->set_z(rotation.z());
  orientation->set_w(rotation.w());
}

}  // namespace steadymap
