#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

namespace steadymap {

/// Errors of the simulated depth camera, the labels and the poses. Every source of error has its
/// own switch, for ablation; the numeric fields set its strength.
struct SensorModel {
  bool depth_noise = true;            ///< Gaussian noise along the ray's depth.
  bool disparity_steps = true;        ///< Depth is quantised to steps of disparity.
  bool correlated_noise = false;      ///< Noise that changes slowly over image and time.
  bool foreground_fattening = false;  ///< Pixels beside a nearer surface take its depth.
  bool flying_pixels = true;          ///< Pixels at depth edges lie between both surfaces.
  bool grazing_dropout = true;        ///< Surfaces at a grazing angle give no depth.
  bool holes = true;                  ///< Round spots without depth.
  bool label_boundary_noise = true;   ///< Pixels beside a border take the other side's label.
  bool label_blobs = true;            ///< Elliptic patches with a wrong class.
  bool label_flips = true;            ///< A whole object takes a wrong class for one frame.
  bool pose_drift = false;            ///< The reported pose drifts slowly about the true one.

  int label_boundary_px = 2;           ///< Width of the noisy band on each side of a border.
  double label_boundary_share = 0.05;  ///< Share of wrong pixels in that band.
  double label_blobs_a_frame = 1;      ///< Expected number in a frame, at most 4.
  double label_flip_share = 0.01;      ///< Share of the objects in view, each frame.
  double unlabelled_share = 0.0;       ///< Share of wrong classes that are 0, which is no class.

  double min_range_m = 0.3;     ///< Nearer surfaces give no depth. Always active.
  double max_range_m = 5.0;     ///< Farther surfaces give no depth. Always active.
  double visible_range_m = 20;  ///< Farther surfaces have no label and no colour either.

  double depth_noise_at_one_metre_m = 0.002;  ///< Sigma at 1 m; below 1 m it decreases with z^2.
  double depth_noise_growth_m = 0.0052;       ///< Growth of sigma per m^2 above 1: 2 % at 4 m.
  double range_noise_share = 0.0;             ///< Sigma grows by this share of the depth, too.
  double correlated_noise_share = 1.0;        ///< Sigma, as share of that of the Gaussian noise.
  int fattening_px = 2;                       ///< Width to either side, along the row.
  double disparity_step_px = 1.0 / 32.0;      ///< One step.
  double stereo_baseline_m = 0.05;            ///< Distance of the two imagers.
  double flying_pixel_share = 0.3;            ///< Share of the pixels at an edge.
  double flying_pixel_jump_m = 0.1;  ///< Depth difference of neighbours that makes an edge.
  double grazing_cosine = 0.17;      ///< Loss begins at this cosine and is total at 0.
  double min_hole_share = 0.02;      ///< Lower limit of a frame's share of lost pixels.
  double max_hole_share = 0.05;      ///< Upper limit of a frame's share of lost pixels.

  double pose_drift_m = 0.015;     ///< Largest offset along any axis.
  double pose_drift_rad = 0.0087;  ///< Largest rotation about any axis.

  /// Error of the localisation that grows with the time since the start of a sequence: a random
  /// walk of the position along each axis, and of the heading. Sigma after one second.
  double pose_walk_m = 0.0;
  double pose_walk_rad = 0.0;

  /// Error of the localisation that is constant during a sequence, and zero in the first one: the
  /// length of a shift in a random direction, and a rotation about the world's z axis to either
  /// side.
  double session_offset_m = 0.0;
  double session_offset_rad = 0.0;

  /// Returns a model without errors, with the same ranges.
  static SensorModel Ideal();

  /// Returns a model with every source of error at its default strength, including drift.
  static SensorModel Full();

  /// Returns a model with the errors of a cheap stereo camera, an unsure classifier and a robot
  /// that loses its way: correlated noise, fattened foreground, 7 % wrong labels, drift without
  /// bound and offsets between sequences.
  static SensorModel Hard();
};

/// Returns the pose reported `time_s` seconds after the start of sequence `session` for
/// `T_world_camera`, with a random walk that depends only on `seed`, `session` and time.
Eigen::Isometry3d WalkPose(const SensorModel& sensor,
                           std::uint64_t seed,
                           std::size_t session,
                           double time_s,
                           const Eigen::Isometry3d& T_world_camera);

/// Returns the reported pose of a camera with the true pose `T_world_camera`, `time_s` seconds
/// after the start of the route: a smooth, bounded drift with periods of 20 to 70 s that depends
/// only on `seed` and time. The identity if `sensor.pose_drift` is off.
Eigen::Isometry3d DriftPose(const SensorModel& sensor,
                            std::uint64_t seed,
                            double time_s,
                            const Eigen::Isometry3d& T_world_camera);

/// Returns the pose reported in sequence `session` for `T_world_camera`, with the offset of that
/// sequence, which depends only on `seed` and `session`.
Eigen::Isometry3d OffsetPose(const SensorModel& sensor,
                             std::uint64_t seed,
                             std::size_t session,
                             const Eigen::Isometry3d& T_world_camera);

}  // namespace steadymap
