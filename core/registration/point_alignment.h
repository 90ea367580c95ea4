#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "core/registration/registration.h"
#include "core/volume/tsdf_sample.h"

/// Private to registration: the robust descent of points onto the surface of a volume.
namespace steadymap {

/// An upright motion of points about their centroid: `p' = R(yaw) (p - centroid) + centroid +
/// shift`, object frame.
struct UprightMotion {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;

  friend bool operator==(const UprightMotion&, const UprightMotion&) = default;
};

/// Rotation about z.
inline Eigen::Matrix3d YawRotation(double yaw_rad) {
  return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// What points say about a motion of them, per point: robust cost, and its derivatives by a step
/// (x, y, z, yaw times lever), metres.
struct AlignmentFit {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();  ///< Mean of the weighted J^T J.
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();     ///< Mean of the weighted J^T distance.
  /// Mean loss in [0, 1]: 0 on the surface, a half at the inlier distance, 1 far away and where
  /// nothing is known.
  double cost = 1.0;
  double known_cost = 1.0;   ///< The mean loss of the known points alone.
  std::size_t known = 0;     ///< Points where the volume knows its distance.
  std::size_t outliers = 0;  ///< Of those: further away than the inlier distance.
};

/// Where a descent ended.
struct AlignmentDescent {
  UprightMotion motion;
  AlignmentFit fit;  ///< At `motion`.
  int iterations = 0;
  bool converged = false;
};

/// Aligns points, given as offsets from their centroid, with one volume. Everything in the object
/// frame, metres. One thread.
class PointAlignment {
 public:
  /// `sampler` must outlive the alignment. `lever_m` > 0: the distance at which a turn counts as a
  /// shift, best the points' root mean square distance from the axis through their centroid.
  PointAlignment(TsdfSampler* sampler,
                 const Eigen::Vector3d& centroid,
                 double lever_m,
                 const RegistrationParameters& parameters);

  double inlier_distance_m() const { return inlier_distance_m_; }

  /// Loss of a point at that distance, [0, 1): Geman-McClure.
  double Loss(double distance_m) const;

  /// The cost and its derivatives; those of no points are the default.
  AlignmentFit Linearize(std::span<const Eigen::Vector3d> offsets, const UprightMotion& motion);

  /// The step (x, y, z, yaw times lever) down the cost; zero along directions that the points do
  /// not determine.
  Eigen::Vector4d Step(const AlignmentFit& fit, double damping) const;

  /// The part of `motion` along directions that the points determine.
  UprightMotion DeterminedPart(const AlignmentFit& fit, const UprightMotion& motion) const;

  /// Goes down the cost from `start` until no step helps or steps are too short to matter.
  AlignmentDescent Descend(std::span<const Eigen::Vector3d> offsets,
                           const UprightMotion& start,
                           int max_iterations);

  /// `motion` and then `step`.
  UprightMotion Advance(const UprightMotion& motion, const Eigen::Vector4d& step) const;

 private:
  bool WithinBounds(const UprightMotion& motion) const;

  TsdfSampler* sampler_;
  Eigen::Vector3d centroid_;
  double lever_m_;
  RegistrationParameters parameters_;
  double inlier_distance_m_;
};

}  // namespace steadymap
