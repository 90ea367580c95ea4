#pragma once

#include <cstdint>

#include <Eigen/Geometry>

namespace steadymap {

/// How far the simulated depth camera, the labels and the poses are from the truth. Every source of
/// error has a switch of its own, for ablation; the figures beside it set its strength.
struct SensorModel {
  bool depth_noise = true;           ///< Gaussian noise along the ray's depth.
  bool disparity_steps = true;       ///< Depth is measured in whole steps of disparity.
  bool flying_pixels = true;         ///< Pixels at depth edges float between both surfaces.
  bool grazing_dropout = true;       ///< Surfaces seen at a flat angle give no depth.
  bool holes = true;                 ///< Round spots without depth.
  bool label_boundary_noise = true;  ///< Pixels beside a border take the other side's label.
  bool label_blobs = true;           ///< Elliptic patches with a wrong class.
  bool label_flips = true;           ///< A whole object takes a wrong class for one frame.
  bool pose_drift = false;           ///< The reported pose wanders slowly about the true one.

  int label_boundary_px = 2;           ///< Width of the noisy band on each side of a border.
  double label_boundary_share = 0.05;  ///< Share of that band's pixels that are wrong.
  double label_blobs_a_frame = 1;      ///< Expected number in a frame, at most 4.
  double label_flip_share = 0.01;      ///< Share of the objects in view, each frame.

  double min_range_m = 0.3;     ///< Nearer surfaces give no depth. Never switched off.
  double max_range_m = 5.0;     ///< Farther surfaces give no depth. Never switched off.
  double visible_range_m = 20;  ///< Farther surfaces have no label and no colour either.

  double depth_noise_at_one_metre_m = 0.002;  ///< Its sigma at 1 m; below, it falls with z^2.
  double depth_noise_growth_m = 0.0052;       ///< Sigma per square metre above 1: 2 % at 4 m.
  double disparity_step_px = 1.0 / 32.0;      ///< One step.
  double stereo_baseline_m = 0.05;            ///< Distance of the two imagers.
  double flying_pixel_share = 0.3;            ///< Share of the pixels at an edge.
  double flying_pixel_jump_m = 0.1;  ///< A neighbour this much nearer or farther makes an edge.
  double grazing_cosine = 0.17;      ///< Loss begins at this cosine and is total at 0.
  double min_hole_share = 0.02;      ///< Each frame draws the share of its pixels that is lost ...
  double max_hole_share = 0.05;      ///< ... between these two.

  double pose_drift_m = 0.015;     ///< Most that it is off along any axis.
  double pose_drift_rad = 0.0087;  ///< Most that it is turned about any axis.

  /// No error at all: what a perfect sensor with the same range would report.
  static SensorModel Ideal();

  /// Every source of error at its default strength, the drift included.
  static SensorModel Full();
};

/// Where drift puts a camera that is truly at `T_world_camera`, `time_s` seconds after the start of
/// the route: a smooth, bounded wander with periods of 20 to 70 s that depends on `seed` and time
/// only. The identity where `sensor.pose_drift` is off.
Eigen::Isometry3d DriftPose(const SensorModel& sensor,
                            std::uint64_t seed,
                            double time_s,
                            const Eigen::Isometry3d& T_world_camera);

}  // namespace steadymap
