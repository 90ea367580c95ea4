#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/map/map_object.h"
#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

/// How an observation's points lie against an object's volume, and by which upright motion they lie
/// there best (pocd.md section 2.4).
namespace steadymap {

/// The constants of `RegisterPoints`. Defaults: TorWIC at voxels of 5 cm.
struct RegistrationParameters {
  /// Of more points than this an even sample is aligned, >= 1. Time grows with it.
  std::size_t max_alignment_points = 400;
  /// Of more points than this an even sample is judged in the end, >= 1. With 1000 the share of
  /// outliers is known to one percent.
  std::size_t max_verdict_points = 1000;

  /// A point further than this from the surface is an outlier, voxels, > 0; the alignment trusts
  /// points at this distance a quarter as much as points on the surface.
  double inlier_distance_voxels = 1.0;
  /// Whether points where the volume knows nothing count as outliers, as in the paper. Otherwise
  /// they do not count: surface that is not mapped yet is no contradiction.
  bool unknown_is_outlier = false;

  /// Motions of the points' centroid are searched this far, metres, >= 0; 0: only what a descent
  /// from the identity reaches. No correction goes further than this and a truncation. Time grows
  /// with the cube of its ratio to the truncation, up to 3 times.
  double search_distance_m = 0.15;
  /// Turns are searched this far to either side, radians, >= 0. No correction turns more than 0.1
  /// beyond it.
  double search_yaw_rad = 0.14;
  /// Share of the points by which another start must explain more than the start at the identity
  /// to be preferred, in [0, 1]. Larger keeps growing objects in place, smaller finds shifts of
  /// which only a sliver of the surface tells.
  double min_gain_share = 0.05;

  /// No other start is looked for once at most this share of the judged points are outliers, in
  /// [0, 1], ...
  double max_consistent_dissimilarity = 0.03;
  /// ... and at least this share of the points is known, in [0, 1]. Larger costs time where objects
  /// grow, smaller overlooks shifts that carry little of the surface beyond the truncation.
  double min_complete_share = 0.95;
  /// The identity needs no step if the first one would be no longer than this, metres, >= 0, ...
  double max_unmoved_shift_m = 0.004;
  /// ... and turn no further than this, radians, >= 0.
  double max_unmoved_yaw_rad = 0.004;

  /// A direction that holds less than this share of the points' normals is not moved along: a plane
  /// does not say how far it slid, in [0, 1]. Noise of 5 degrees in normals feigns 0.8 %.
  double min_direction_share = 0.015;
  /// Steps at most from one start, >= 0.
  int max_iterations = 12;

  friend bool operator==(const RegistrationParameters&, const RegistrationParameters&) = default;
};

/// How points lie against a volume once they are moved.
struct Registration {
  /// Moves the points onto the object: `p_world_corrected = T_correction * p_world`. Upright: turns
  /// about z only. If the object was mapped right and moved since, it moved by the inverse.
  Eigen::Isometry3d T_correction = Eigen::Isometry3d::Identity();
  /// What the correction adds to the centroid of the aligned points, world frame, metres: p_ij of
  /// the association's cost. Unlike the translation of `T_correction` it does not grow with the
  /// distance from the world's origin.
  Eigen::Vector3d shift_world = Eigen::Vector3d::Zero();
  double yaw_rad = 0.0;  ///< The turn of `T_correction`, yaw_ij of the association's cost.

  /// Share of outliers among the judged points after the correction, eps_ij; 1 where none could be
  /// judged.
  double dissimilarity = 1.0;
  /// Share of the points where the volume knows its distance, after the correction. A small
  /// dissimilarity of few known points says little.
  double known_share = 0.0;
  /// Root mean square distance of the inliers from the surface, metres; 0 without inliers.
  double inlier_rms_m = 0.0;
  /// Steps to the correction, the one to its start among them; 0: the points stayed where they
  /// were.
  int iterations = 0;
  /// Whether no further step would have helped. False without known points.
  bool converged = false;
};

/// Registers an observation's points (world frame, metres) to the volume of an object at
/// `T_world_object`: a robust Gauss-Newton descent in x, y, z and yaw on the volume's distances,
/// with its gradients as normals, from the identity and from the most promising of a lattice of
/// starts, since beyond the truncation a volume says nothing.
///
/// Points that already fit stay where they are, to the bit; so does what the points and the volume
/// do not determine, such as sliding along a wall. Points that are not finite are left out; without
/// any left the correction is the identity. Same input, same result. Cost: about 0.1 ms where the
/// points fit as they lie, 0.3 ms where they moved, 0.6 ms where they belong to something else;
/// more if neighbours in the span are not neighbours in space.
Registration RegisterPoints(std::span<const Eigen::Vector3d> points_world,
                            const VoxelReader& volume,
                            const VoxelScale& scale,
                            const UprightPose& T_world_object,
                            const RegistrationParameters& parameters = {});

}  // namespace steadymap
