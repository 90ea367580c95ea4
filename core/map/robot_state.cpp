#include "core/map/robot_state.h"

#include "core/geometry/geometry.h"

namespace steadymap {

CameraPlace CameraPlace::FromIsometry(const Eigen::Isometry3d& T_world_camera) {
  const Eigen::AngleAxisd turn(T_world_camera.linear());
  return {T_world_camera.translation(), (turn.angle() * turn.axis()).cast<float>()};
}

Eigen::Isometry3d CameraPlace::ToIsometry() const {
  return TransformOf(position_world, rotation_world.cast<double>());
}

Eigen::Isometry3d PoseOffset::ToIsometry() const {
  return Eigen::Translation3d(center_world + shift_world) *
         Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(-center_world);
}

}  // namespace steadymap
