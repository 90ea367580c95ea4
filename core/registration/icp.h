#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/working/tracked_object.h"

/// Registration of points to points by PCL's point-to-plane ICP, the method of Qian et al., RSS
/// 2022, for comparison with registration.h.
namespace steadymap {

/// The constants of `IcpTarget`.
struct IcpParameters {
  /// Maximum number of aligned points, >= 1; larger sets are sampled evenly. The time grows with
  /// it.
  std::size_t max_points = 1000;
  /// Maximum distance of a pair of points, metres, > 0. A smaller value limits the motions that can
  /// be found; a larger value lets points of other surfaces bias the result.
  double max_pair_distance_m = 0.30;
  /// A point without a target point within this distance after alignment is an outlier, metres, >
  /// 0.
  double outlier_distance_m = 0.10;
  /// Maximum number of steps, >= 1.
  int max_iterations = 50;

  friend bool operator==(const IcpParameters&, const IcpParameters&) = default;
};

/// The result of an ICP registration.
struct IcpFit {
  /// Moves the points onto the target, world frame: a translation and a rotation about z.
  Eigen::Isometry3d T_correction = Eigen::Isometry3d::Identity();
  /// Displacement of the centroid of the points by the correction, metres.
  Eigen::Vector3d shift_world = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;        ///< Rotation of the correction about z.
  double outlier_share = 1.0;  ///< Share of the corrected points; 1 without convergence.
};

/// The surface of an object as the target of ICP: points and normals in a k-d tree.
class IcpTarget {
 public:
  /// Copies the current surface of `object`.
  explicit IcpTarget(const TrackedObject& object, const IcpParameters& parameters = {});
  ~IcpTarget();
  IcpTarget(const IcpTarget&) = delete;
  IcpTarget& operator=(const IcpTarget&) = delete;

  /// Registers points (world frame, metres) to the target, starting at their given positions.
  /// Ignores points that are not finite. With fewer than ten points, or a target of fewer, returns
  /// the default `IcpFit`.
  IcpFit Align(std::span<const Eigen::Vector3d> points_world);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace steadymap
