#pragma once

#include <cstddef>

#include <Eigen/Core>

namespace steadymap {

/// When surface counts as turned.
struct YawChangeParameters {
  /// Turn about the vertical axis, radians, that must be exceeded by more than the standard
  /// deviation with which it is known; 0: never. Looks at what stands still stay below it, pose
  /// error included; boxes that are pushed or put back seldom do.
  double turned_rad = 0.1;
  /// Greatest standard deviation with which the turn may be known, radians.
  double max_error_rad = 0.06;
  /// How far the turn must move the surface along its normals, metres, root mean square: depth that
  /// errs alike all over a round thing looks like a turn, too, but explains less.
  double min_offset_m = 0.015;
};

/// How far surface is turned about a vertical axis against what is known of it: the least squares
/// of the distances between both, point to plane. Shifts do not matter.
class YawChangeSum {
 public:
  /// Adds a known point with its unit normal, and how far in front of it the surface was found,
  /// metres, all in one upright frame.
  void Add(const Eigen::Vector3d& position, const Eigen::Vector3d& normal, double offset_m);

  /// An estimate of the turn.
  struct Turn {
    double angle_rad = 0.0;  ///< Counterclockwise from above.
    double error_rad = 0.0;  ///< Standard deviation; over 1000 if nothing is known.
    double offset_m = 0.0;   ///< By which the turn moves the points, root mean square.
  };

  Turn Estimate() const;

  bool Exceeds(const YawChangeParameters& parameters) const;

 private:
  std::size_t count_ = 0;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< The first point.
  // Normal equations of the turn about the origin, and the shift along x and y.
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d projected_ = Eigen::Vector3d::Zero();
};

}  // namespace steadymap
