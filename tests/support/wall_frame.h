#pragma once

#include <cstdint>

#include "core/geometry/geometry.h"

#include "steadymap/v1/frame.pb.h"

namespace steadymap {

/// A small frame of a flat wall, in the form that a robot uploads.
struct WallFrame {
  int width_px = 64;
  int height_px = 48;
  double wall_distance_m = 2.0;                         ///< Along the camera's z axis.
  Eigen::Vector3d eye_world = Eigen::Vector3d::Zero();  ///< The camera faces along world x.
  double capture_time_s = 100.0;                        ///< Since 1970.
  v1::DepthEncoding encoding = v1::DEPTH_ENCODING_RAW_UINT16;
  bool with_labels = true;  ///< All pixels are class 4.
};

/// Renders the frame: every pixel has the wall's distance, so the wall is the plane x = eye +
/// distance.
v1::Frame MakeWallFrame(const WallFrame& wall = {});

}  // namespace steadymap
