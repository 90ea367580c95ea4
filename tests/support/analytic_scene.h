#pragma once

#include <cstdint>
#include <vector>

#include "core/frame/frame.h"
#include "tests/support/analytic_depth.h"
#include "tests/support/analytic_solid.h"

namespace steadymap::testing {

inline constexpr std::uint16_t kWallClass = 4;
inline constexpr std::uint16_t kGoodsClass = 7;
inline constexpr std::uint16_t kPersonClass = 13;

/// A box of one class.
struct SceneBody {
  Box box_world;
  std::uint16_t label = 0;
};

/// All bodies of a scene.
using Scene = std::vector<SceneBody>;

/// Returns the body between two corners.
inline SceneBody Body(std::uint16_t label,
                      const Eigen::Vector3d& low_world,
                      const Eigen::Vector3d& high_world) {
  return {Box(low_world, high_world), label};
}

/// One view of a scene.
struct SceneLook {
  Eigen::Vector3d eye_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_world = Eigen::Vector3d::UnitX();
  double capture_time_s = 100.0;  ///< Since 1970.
};

/// Renders the frame of a view with the class of each pixel; 0 without a hit.
inline Frame RenderScene(const Scene& scene, const SceneLook& look) {
  Solid solid;
  std::vector<RangeFunction> ranges;
  for (const SceneBody& body : scene) {
    solid.push_back(body.box_world);
    ranges.push_back(RangeTo({body.box_world}));
  }
  const Eigen::Isometry3d T_world_camera = LookAt(look.eye_world, look.target_world);
  const RangeFunction nearest = RangeTo(solid);
  Frame frame = RenderAnalytic(nearest, AnalyticCamera(), T_world_camera);
  frame.capture_time = Timestamp::FromSeconds(look.capture_time_s);
  frame.labels = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      const Eigen::Vector3d direction = T_world_camera.linear() * frame.camera.Ray(u, v);
      const double range = nearest(look.eye_world, direction);
      for (std::size_t i = 0; i < scene.size(); ++i) {
        if (ranges[i](look.eye_world, direction) == range) frame.labels.At(u, v) = scene[i].label;
      }
    }
  }
  return frame;
}

/// Returns the frame of a sensor with the maximum range `reach_m`.
inline Frame WithReach(Frame frame, double reach_m) {
  const auto farthest = static_cast<std::uint16_t>(reach_m / frame.depth.metres_per_unit);
  for (std::size_t i = 0; i < frame.depth.units.size(); ++i) {
    std::uint16_t& units = frame.depth.units.data()[i];
    if (units > farthest) units = kNoDepth;
  }
  return frame;
}

}  // namespace steadymap::testing
