#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace steadymap {

/// A point with the plane of known surface that it was registered to, world frame, metres.
struct PlaneMatch {
  Eigen::Vector3d point_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_world = Eigen::Vector3d::Zero();  ///< Unit, of the surface at the target.
};

/// The matches of the points of one thing.
using AnchorMatches = std::vector<PlaneMatch>;

/// What `AlignToAnchors` starts from.
struct AlignmentPrior {
  /// The motion that the claimed poses need without any anchor.
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  double votes = 1.5;  ///< Of it, >= 0; each anchor has one.
};

/// The result of `AlignToAnchors`.
struct AnchorAlignment {
  /// A translation and a rotation about the vertical axis, world frame.
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  ///< Of all points.
  double lever_m = 1.0;  ///< Root mean square horizontal distance of points from the centre.
  /// Anchors that have not lost half of their vote.
  std::size_t agreeing = 0;
  /// What they tell of the shift of the centre (x, y, z) and the yaw: the inverse covariance for a
  /// residual with a standard deviation of one metre.
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
};

/// Finds the motion of all points that most anchors agree with. Each anchor has one vote, whatever
/// its size, since a thing that moved moved as a whole. An anchor that lies `scale_m` off its
/// planes, root mean square, has lost half of its vote. `starts` are the motions to begin with,
/// besides that of the prior. Without anchors, returns the motion of the prior.
AnchorAlignment AlignToAnchors(std::span<const AnchorMatches> anchors,
                               std::span<const Eigen::Isometry3d> starts,
                               double scale_m,
                               const AlignmentPrior& prior);

}  // namespace steadymap
