#pragma once

#include <Eigen/Geometry>

#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// How far something lies along each pixel of one picture.
struct DepthView {
  PinholeCamera camera;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  Image<float> depth_m;  ///< Along the camera's z axis; 0: unknown; infinite: nothing there.
};

/// The view that a recorded frame gives.
DepthView ViewOf(const Frame& frame);

}  // namespace steadymap
