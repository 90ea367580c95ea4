#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace steadymap {

/// A box that stands upright: turned about the world's z axis only (pocd.md section 1).
struct Cuboid {
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  ///< Metres.
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();        ///< Full side lengths, each >= 0.
  double yaw_rad = 0.0;  ///< From the world's x axis to the box's.

  /// The frame of the box: origin at its centre, z up.
  Eigen::Isometry3d T_world_cuboid() const;

  /// Corners of the base, counter-clockwise seen from above, metres.
  std::array<Eigen::Vector2d, 4> BaseCorners() const;

  double lowest_m() const { return center_world.z() - 0.5 * size_m.z(); }

  double highest_m() const { return center_world.z() + 0.5 * size_m.z(); }

  double volume_m3() const { return size_m.prod(); }

  friend bool operator==(const Cuboid&, const Cuboid&) = default;
};

/// Distance of a point from the box, metres; 0 inside.
double DistanceTo(const Cuboid& cuboid, const Eigen::Vector3d& point_world);

/// Least distance between two boxes, metres; 0 where they touch or overlap.
double DistanceBetween(const Cuboid& a, const Cuboid& b);

/// Volume that two boxes share, cubic metres.
double OverlapM3(const Cuboid& a, const Cuboid& b);

/// The upright box around points whose sides follow the major and minor axis of the points seen
/// from above (PCA); zero size for no points.
Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world);

/// The box with that heading around points.
Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world, double yaw_rad);

}  // namespace steadymap
