#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/working/tracked_object.h"

/// Registration of points to points by PCL's point-to-plane ICP, as POCD's paper has it, to compare
/// with registration.h.
namespace steadymap {

/// The constants of `IcpTarget`.
struct IcpParameters {
  /// Of more points than this an even part is aligned and judged, >= 1. Time grows with it.
  std::size_t max_points = 1000;
  /// Points further apart than this are no pair, metres, > 0. Less finds no large motion, more lets
  /// what belongs elsewhere pull.
  double max_pair_distance_m = 0.30;
  /// A point that finds none within this in the end is an outlier, metres, > 0.
  double outlier_distance_m = 0.10;
  /// Steps at most, >= 1.
  int max_iterations = 50;

  friend bool operator==(const IcpParameters&, const IcpParameters&) = default;
};

/// Where ICP brought points.
struct IcpFit {
  /// Moves the points onto the target, world frame. Upright: turns about z only.
  Eigen::Isometry3d T_correction = Eigen::Isometry3d::Identity();
  /// What the correction adds to the centroid of the points, metres.
  Eigen::Vector3d shift_world = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;        ///< Its turn about z.
  double outlier_share = 1.0;  ///< Of the points, once corrected; 1 where it did not converge.
};

/// An object's surface as ICP takes it: points and normals, in a k-d tree.
class IcpTarget {
 public:
  /// Copies the surface of `object` as it is now.
  explicit IcpTarget(const TrackedObject& object, const IcpParameters& parameters = {});
  ~IcpTarget();
  IcpTarget(const IcpTarget&) = delete;
  IcpTarget& operator=(const IcpTarget&) = delete;

  /// Registers points (world frame, metres) to the target, from where they lie. Points that are not
  /// finite are left out. Fewer than ten points, or a target of fewer, fit nowhere.
  IcpFit Align(std::span<const Eigen::Vector3d> points_world);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace steadymap
