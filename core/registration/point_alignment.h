#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "core/registration/registration.h"
#include "core/volume/tsdf_sample.h"

/// Private to registration: the robust alignment of points with the surface of a volume.
namespace steadymap {

/// A motion of points about their centroid with a translation and a yaw:
/// `p' = R(yaw) (p - centroid) + centroid + shift`, object frame.
struct UprightMotion {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;

  friend bool operator==(const UprightMotion&, const UprightMotion&) = default;
};

/// Returns the rotation about z.
inline Eigen::Matrix3d YawRotation(double yaw_rad) {
  return Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// The robust cost per point at a motion, and its derivatives by a step (x, y, z, yaw times lever),
/// metres.
struct AlignmentFit {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();  ///< Mean of the weighted J^T J.
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();     ///< Mean of the weighted J^T distance.
  /// Mean loss in [0, 1]: 0 on the surface, 1/2 at the inlier distance, 1 far away and at unknown
  /// points.
  double cost = 1.0;
  double known_cost = 1.0;   ///< Mean loss of the known points.
  std::size_t known = 0;     ///< Number of points with a known distance.
  std::size_t outliers = 0;  ///< Of the known points: further away than the inlier distance.
};

/// The result of a descent.
struct AlignmentDescent {
  UprightMotion motion;
  AlignmentFit fit;  ///< At `motion`.
  int iterations = 0;
  bool converged = false;
};

/// Aligns points, given as offsets from their centroid, with one volume. Object frame, metres. One
/// thread at a time.
class PointAlignment {
 public:
  /// `sampler` must outlive the alignment. `lever_m` > 0 converts rotations to metres; best the
  /// root mean square distance of the points from the vertical axis through their centroid.
  PointAlignment(TsdfSampler* sampler,
                 const Eigen::Vector3d& centroid,
                 double lever_m,
                 const RegistrationParameters& parameters);

  double inlier_distance_m() const { return inlier_distance_m_; }

  /// Returns the Geman-McClure loss of a point at that distance, [0, 1).
  double Loss(double distance_m) const;

  /// Computes the cost and its derivatives at `motion`; the default without points.
  AlignmentFit Linearize(std::span<const Eigen::Vector3d> offsets, const UprightMotion& motion);

  /// Returns the damped Gauss-Newton step (x, y, z, yaw times lever); zero along directions that
  /// the points do not determine.
  Eigen::Vector4d Step(const AlignmentFit& fit, double damping) const;

  /// Returns the part of `motion` along directions that the points determine.
  UprightMotion DeterminedPart(const AlignmentFit& fit, const UprightMotion& motion) const;

  /// Minimises the cost from `start` with at most `max_iterations` steps, until the steps are
  /// negligible.
  AlignmentDescent Descend(std::span<const Eigen::Vector3d> offsets,
                           const UprightMotion& start,
                           int max_iterations);

  /// Returns the composition of `motion` and `step`.
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
