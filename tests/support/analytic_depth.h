#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>

#include "core/frame/frame.h"

namespace steadymap::testing {

/// Fine enough that the rounding of depth is negligible in tests.
inline constexpr double kAnalyticMetresPerUnit = 1e-4;

/// A camera of 320 x 240 pixels with a field of view of 60 degrees.
inline PinholeCamera AnalyticCamera() { return {320, 240, 277.0, 277.0, 159.5, 119.5}; }

/// Returns a pose at `eye` facing `target`, both in the world frame, with the image's top up.
inline Eigen::Isometry3d LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d up =
      std::abs(forward.z()) < 0.99 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.translation() = eye;
  T_world_camera.linear().col(0) = right;
  T_world_camera.linear().col(1) = forward.cross(right);
  T_world_camera.linear().col(2) = forward;
  return T_world_camera;
}

/// Range along a ray (world origin, world direction of any length) in multiples of the direction,
/// or NaN without a hit.
using RangeFunction = std::function<double(const Eigen::Vector3d&, const Eigen::Vector3d&)>;

/// The plane `normal . p = offset`.
inline RangeFunction Plane(const Eigen::Vector3d& normal, double offset) {
  return [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const double range = (offset - normal.dot(origin)) / normal.dot(direction);
    return range > 0.0 ? range : std::nan("");
  };
}

inline RangeFunction Sphere(const Eigen::Vector3d& center, double radius) {
  return [=](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    const Eigen::Vector3d from_center = origin - center;
    const double a = direction.squaredNorm();
    const double b = from_center.dot(direction);
    const double c = from_center.squaredNorm() - radius * radius;
    const double discriminant = b * b - a * c;
    return discriminant < 0.0 ? std::nan("") : (-b - std::sqrt(discriminant)) / a;
  };
}

/// Adds Gaussian noise with the standard deviation `sigma_at(depth_m)`, metres, to each depth.
inline void AddNoise(const std::function<double(double)>& sigma_at,
                     std::uint64_t seed,
                     DepthImage* depth) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < depth->units.size(); ++i) {
    std::uint16_t& units = depth->units.data()[i];
    if (units == 0) continue;
    const double depth_m = units * depth->metres_per_unit;
    const double noisy_m = depth_m + sigma_at(depth_m) * normal(random);
    units = static_cast<std::uint16_t>(std::lround(noisy_m / depth->metres_per_unit));
  }
}

/// Renders a surface for `camera` at `T_world_camera`. Without noise.
inline Frame RenderAnalytic(const RangeFunction& surface,
                            const PinholeCamera& camera,
                            const Eigen::Isometry3d& T_world_camera) {
  Frame frame;
  frame.source = {"robot", SensorName::kDefaultSensor};
  frame.camera = camera;
  frame.T_world_camera = T_world_camera;
  frame.depth.metres_per_unit = kAnalyticMetresPerUnit;
  frame.depth.units = Image<std::uint16_t>(camera.width_px, camera.height_px);
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      // The camera ray has z = 1, so the range in multiples of it is the depth.
      const double depth_m =
          surface(T_world_camera.translation(), T_world_camera.linear() * camera.Ray(u, v));
      if (depth_m > 0.0 && depth_m < 6.0) {
        frame.depth.units.At(u, v) =
            static_cast<std::uint16_t>(std::lround(depth_m / kAnalyticMetresPerUnit));
      }
    }
  }
  return frame;
}

}  // namespace steadymap::testing
