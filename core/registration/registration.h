#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/map/map_object.h"
#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

/// Registration of an observation's points to an object's volume: the relative pose and
/// dissimilarity of data association (Qian et al., RSS 2022), by a robust descent on the TSDF
/// instead of ICP.
namespace steadymap {

/// The constants of `RegisterPoints`. Defaults: TorWIC with voxels of 5 cm.
struct RegistrationParameters {
  /// Maximum number of aligned points, >= 1; larger sets are sampled evenly. The time grows with
  /// it.
  std::size_t max_alignment_points = 400;
  /// Maximum number of points for the final verdict, >= 1; larger sets are sampled evenly. 1000
  /// points determine the share of outliers to one percent.
  std::size_t max_verdict_points = 1000;

  /// A point further than this from the surface is an outlier, voxels, > 0. At this distance a
  /// point has a quarter of the weight of a point on the surface.
  double inlier_distance_voxels = 1.0;
  /// True: points in unknown space count as outliers, as in Qian et al., RSS 2022. False: they are
  /// ignored, since a surface that is not mapped yet is not a contradiction.
  bool unknown_is_outlier = false;

  /// Radius of the search for the translation of the centroid, metres, >= 0. 0: only the descent
  /// from the identity. A correction is at most this plus the truncation distance. The time grows
  /// with the cube of its ratio to the truncation distance, up to a ratio of 3.
  double search_distance_m = 0.15;
  /// Range of the search for the yaw to either side, radians, >= 0. A correction exceeds it by at
  /// most 0.1.
  double search_yaw_rad = 0.14;
  /// Minimum decrease of the cost, as a share of the points, for which another start replaces the
  /// start at the identity, in [0, 1]. A larger value keeps growing objects in place; a smaller
  /// value finds shifts that are visible in a small part of the surface only.
  double min_gain_share = 0.05;

  /// Maximum share of outliers among the judged points at which the search for other starts ends,
  /// in [0, 1]; requires `min_complete_share`, too.
  double max_consistent_dissimilarity = 0.03;
  /// Minimum share of known points at which the search for other starts ends, in [0, 1]. A larger
  /// value takes more time for growing objects; a smaller value misses shifts that move little of
  /// the surface beyond the truncation distance.
  double min_complete_share = 0.95;
  /// Maximum translation of the first step at which the points are not moved, metres, >= 0.
  double max_unmoved_shift_m = 0.004;
  /// Maximum rotation of the first step at which the points are not moved, radians, >= 0.
  double max_unmoved_yaw_rad = 0.004;

  /// There is no motion along a direction with less than this share of the points' normals, in [0,
  /// 1]: a plane does not determine a shift along itself. Noise of 5 degrees in the normals has a
  /// share of 0.8 %.
  double min_direction_share = 0.015;
  /// Maximum number of steps from one start, >= 0.
  int max_iterations = 12;

  friend bool operator==(const RegistrationParameters&, const RegistrationParameters&) = default;
};

/// The result of a registration.
struct Registration {
  /// Moves the points onto the object: `p_world_corrected = T_correction * p_world`. A translation
  /// and a rotation about z. If the object moved after it was mapped correctly, it moved by the
  /// inverse.
  Eigen::Isometry3d T_correction = Eigen::Isometry3d::Identity();
  /// Displacement of the centroid of the aligned points by the correction, world frame, metres:
  /// p_ij of the association cost. Unlike the translation of `T_correction`, it is independent of
  /// the distance from the world origin.
  Eigen::Vector3d shift_world = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;  ///< Rotation of `T_correction`: yaw_ij of the association cost.

  /// Share of outliers among the judged points after the correction, eps_ij; 1 without judged
  /// points.
  double dissimilarity = 1.0;
  /// Share of the points with a known distance after the correction. A low dissimilarity with a low
  /// known share is weak evidence.
  double known_share = 0.0;
  /// Mean loss of the aligned points with a known distance after the correction, [0, 1].
  double known_loss = 1.0;
  /// The same, and the share of these points, without the correction.
  double known_loss_at_rest = 1.0;
  double known_share_at_rest = 0.0;
  /// Root mean square distance of the inliers from the surface, metres; 0 without inliers.
  double inlier_rms_m = 0.0;
  /// Number of steps, including the jump to the start. 0: the points were not moved.
  int iterations = 0;
  /// True if no further step improves the result. False without known points.
  bool converged = false;
};

/// Registers an observation's points (world frame, metres) to the volume of an object at
/// `T_world_object`. Runs a robust Gauss-Newton descent in x, y, z and yaw on the distances of the
/// volume, with its gradients as normals. Starts at the identity and at the best starts of a
/// lattice, since the volume is unknown beyond the truncation distance.
///
/// Points that already fit are not moved, to the bit, nor is there motion along undetermined
/// directions, such as a shift along a wall. Ignores points that are not finite; without any others
/// the correction is the identity. Deterministic. Cost: about 0.1 ms if the points fit in place,
/// 0.3 ms if they moved, 0.6 ms if they belong to another object; more if neighbours in the span
/// are not neighbours in space.
Registration RegisterPoints(std::span<const Eigen::Vector3d> points_world,
                            const VoxelReader& volume,
                            const VoxelScale& scale,
                            const UprightPose& T_world_object,
                            const RegistrationParameters& parameters = {});

}  // namespace steadymap
