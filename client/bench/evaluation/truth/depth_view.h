#pragma once

#include <Eigen/Geometry>

#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// A depth image with camera and pose.
struct DepthView {
  PinholeCamera camera;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  Image<float> depth_m;  ///< Along the camera's z axis; 0: unknown; infinite: no surface.
};

/// Returns the view of a recorded frame.
DepthView ViewOf(const Frame& frame);

}  // namespace steadymap
