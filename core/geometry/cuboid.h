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

/// Least distance between two boxes, metres; 0 where they touch or overlap. Boxes without thickness
/// count as the rectangles, lines and points that they are.
double DistanceBetween(const Cuboid& a, const Cuboid& b);

/// Volume that two boxes share, cubic metres; 0 where either has no thickness.
double OverlapM3(const Cuboid& a, const Cuboid& b);

/// The least upright box around points of a surface that has the heading with which they lie
/// nearest to its sides, in the mean; x along the longer side, yaw in (-pi/2, pi/2], to an eighth
/// of a degree.
///
/// So a thing of which two sides were seen, an L from above, has the heading of these sides. That
/// of their major axis, as in the paper, is turned towards the diagonal; nor does the least area
/// tell, which is the same along the diagonal (Zhang, Xu, Dong and Dolan, "Efficient L-shape
/// fitting for vehicle detection using laser scanners", 2017).
///
/// Points are finite. Zero size at the origin for no points, zero size at the point for one; points
/// without a heading (all in one place, or round) get one that rounding decides, the same for the
/// same points in the same order. Cost: 40 us for 1024 points; of more, so many tell the heading.
Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world);

/// The least box with that heading around finite points; zero size at the origin for no points.
Cuboid FitCuboid(std::span<const Eigen::Vector3d> points_world, double yaw_rad);

}  // namespace steadymap
