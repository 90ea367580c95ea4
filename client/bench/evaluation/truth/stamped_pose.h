#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/types/timestamp.h"

namespace steadymap {

/// A camera pose at a time.
struct StampedPose {
  Timestamp time;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
};

/// By increasing time.
using CameraPath = std::vector<StampedPose>;

}  // namespace steadymap
