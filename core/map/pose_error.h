#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Geometry>

#include "core/types/timestamp.h"

namespace steadymap {

/// The first three numbers: shift of a camera, metres. The others: rotation about the camera, axis
/// times angle, radians. World frame.
using PoseErrorVector = Eigen::Matrix<double, 6, 1>;

/// The correction of a claimed camera pose to one that agrees with the map, with its uncertainty.
struct PoseError {
  PoseErrorVector mean = PoseErrorVector::Zero();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();

  /// Returns the corrected pose of a camera.
  Eigen::Isometry3d Correct(const Eigen::Isometry3d& T_world_camera) const;

  friend bool operator==(const PoseError&, const PoseError&) = default;
};

/// Standard deviation of the place of a thing that nobody moved, as two looks at it tell, metres.
inline constexpr double kPlaceSigmaM = 0.005;

/// Number of assumptions on how fast pose errors change.
inline constexpr std::size_t kPoseErrorHypotheses = 3;

/// The pose error under one assumption on how fast it changes.
struct PoseErrorHypothesis {
  PoseError error;
  double probability = 1.0 / kPoseErrorHypotheses;

  friend bool operator==(const PoseErrorHypothesis&, const PoseErrorHypothesis&) = default;
};

/// The pose error of a sensor at a frame (`robot/pose_filter.h`).
struct PoseErrorEstimate {
  Timestamp time;  ///< Capture time of the frame.
  /// The one of the fastest change first; probabilities with the sum 1.
  std::array<PoseErrorHypothesis, kPoseErrorHypotheses> hypotheses;

  /// Returns mean and covariance over all hypotheses.
  PoseError Combined() const;

  /// Moves the corrected pose of a camera by a motion of the world frame.
  void Move(const Eigen::Isometry3d& motion, const Eigen::Vector3d& claimed_camera_world);

  friend bool operator==(const PoseErrorEstimate&, const PoseErrorEstimate&) = default;
};

}  // namespace steadymap
