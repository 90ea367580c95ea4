#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace steadymap {

/// Motion of a camera during one sequence.
struct Trajectory {
  double duration_s = 0.0;      ///< Length of the sequence, > 0.
  double frame_period_s = 0.1;  ///< Time between frames at stride 1, > 0.
  double stop_s = 0.0;          ///< The camera stops half way for so long, and takes no frames.
  /// Returns the pose of the camera `time_s` seconds after the start, in [0, duration_s].
  std::function<Eigen::Isometry3d(double time_s)> T_world_camera;
};

/// A path over the ground: straight legs joined by circular corners. Measured by arc length.
class GroundPath {
 public:
  /// Builds a path through `corners_world` (>= 2, or >= 3 if closed), each rounded with
  /// `corner_radius_m`, or less if a leg is too short. A closed path starts in the middle of its
  /// last leg.
  GroundPath(const std::vector<Eigen::Vector2d>& corners_world,
             double corner_radius_m,
             bool is_closed);

  double length_m() const { return length_m_; }

  /// Returns position and heading (x forward, y left, z up, at z = 0) after `distance_m`, which is
  /// taken modulo the length on a closed path and clamped to [0, length] on an open one.
  Eigen::Isometry3d PoseAt(double distance_m) const;

 private:
  struct Piece {
    Eigen::Vector2d start_world;
    double start_heading_rad = 0.0;
    double length_m = 0.0;
    double curvature_per_m = 0.0;  ///< Left turns are positive; 0 is straight.
  };

  void AppendLine(const Eigen::Vector2d& from_world, const Eigen::Vector2d& to_world);

  std::vector<Piece> pieces_;
  double length_m_ = 0.0;
  bool is_closed_ = false;
};

/// Height above the ground of the base frame of the robot in the TorWIC recordings.
inline constexpr double kTorwicBaseHeightM = 0.49;

/// Drives a robot with the TorWIC camera along `path` at constant speed, from end to end, or once
/// round a closed path. Its base frame is `base_height_m` above the ground.
Trajectory DriveAlong(const GroundPath& path, double speed_m_per_s, double base_height_m);

/// Returns the camera pose at `eye_world` with `target_world` in the centre of the picture and the
/// picture upright. `eye_world` must not be vertically above or below `target_world`.
Eigen::Isometry3d LookAt(const Eigen::Vector3d& eye_world, const Eigen::Vector3d& target_world);

}  // namespace steadymap
