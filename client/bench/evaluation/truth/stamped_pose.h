#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/types/timestamp.h"

namespace steadymap {

/// A camera pose at a time.
struct StampedPose {
  Timestamp time;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  /// Of the error of the pose, in the coordinates of `PoseErrorVector`; none if nobody states it.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance{};
};

/// By increasing time.
using CameraPath = std::vector<StampedPose>;

}  // namespace steadymap
