#pragma once

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

/// Returns the motion of all points, a translation and a rotation about the vertical axis, that
/// most anchors agree with. Each anchor has one vote, whatever its size, since a thing that moved
/// moved as a whole; the claimed pose, the identity, has `claim_votes`. An anchor that lies
/// `scale_m` off its planes, root mean square, has lost half of its vote. `starts` are the motions
/// to begin with, besides the identity.
Eigen::Isometry3d AlignToAnchors(std::span<const AnchorMatches> anchors,
                                 std::span<const Eigen::Isometry3d> starts,
                                 double scale_m,
                                 double claim_votes);

}  // namespace steadymap
