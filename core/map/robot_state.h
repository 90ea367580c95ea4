#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/cell_index.h"
#include "core/map/pose_error.h"
#include "core/types/timestamp.h"

namespace steadymap {

/// The trust of a map in the poses of a robot.
enum class Trust {
  kTrusted,  ///< Its frames are used.
  kDoubted,  ///< Its pose jumped. Frames that fit better without the jump are ignored.
  kLost,     ///< Its frames fit clearly better without the jump, and are ignored.
};

/// A camera pose for storage; the rotation has single precision.
struct CameraPlace {
  Eigen::Vector3d position_world = Eigen::Vector3d::Zero();  ///< Metres.
  /// From the camera frame to the world frame: axis times angle, radians.
  Eigen::Vector3f rotation_world = Eigen::Vector3f::Zero();

  static CameraPlace FromIsometry(const Eigen::Isometry3d& T_world_camera);

  Eigen::Isometry3d ToIsometry() const;

  friend bool operator==(const CameraPlace&, const CameraPlace&) = default;
};

/// A cell in which a robot observed surface of a dynamic class.
struct MovingCell {
  CellIndex cell;             ///< A cell of `MapSnapshot::free_space`, world frame.
  Timestamp seen;             ///< Capture time of the last frame that observed it.
  bool is_confirmed = false;  ///< True if two frames within the memory observed it.

  friend bool operator==(const MovingCell&, const MovingCell&) = default;
};

/// The error of the poses of a session at its end, found by the registration of its frames and by
/// the known objects that the robot saw in place. A claimed point `p` is at
/// `center + R_z(yaw) (p - center) + shift`.
struct PoseOffset {
  Timestamp time;  ///< Capture time of the last frame of the session.
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  ///< Of the known objects, metres.
  Eigen::Vector3d shift_world = Eigen::Vector3d::Zero();   ///< Metres.
  double yaw_rad = 0.0;
  /// Of the shift (x, y, z) and the yaw; metres and radians.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  std::uint32_t anchors = 0;  ///< Known objects that agree with it, at least one.

  /// Returns the motion of claimed points onto the map, world frame.
  Eigen::Isometry3d ToIsometry() const;

  friend bool operator==(const PoseOffset&, const PoseOffset&) = default;
};

/// The state of a robot in a map: for the detection of wrong poses (`localization_monitor.h`), for
/// the mask of moving surface in front of its camera (`dynamic_mask.h`), and for the end of its
/// session (`MapUpdater::IsSessionOver`).
struct RobotState {
  Trust trust = Trust::kTrusted;
  /// Log-odds that the robot is at `claimed`, and that it is at `likely`, against any other place.
  /// 0 in state `kTrusted`.
  float claimed_log_odds = 0.0F;
  float likely_log_odds = 0.0F;
  Timestamp last_capture_time;  ///< Of its last frame, used or not.
  CameraPlace claimed;          ///< The pose given in its last frame.
  /// The pose integrated from the motion since the last trusted pose, without jumps. Equals
  /// `claimed` in state `kTrusted`.
  CameraPlace likely;
  /// Velocities of the last plausible motion, camera frame. The angular velocity is axis times
  /// rate.
  Eigen::Vector3f velocity_m_per_s = Eigen::Vector3f::Zero();
  Eigen::Vector3f turn_rad_per_s = Eigen::Vector3f::Zero();
  std::vector<MovingCell> moving;  ///< By increasing cell, without duplicates.
  /// Capture time of the first frame of its session; none if its session has ended.
  std::optional<Timestamp> session_start;
  /// Of its last session that ended; none if that showed no known object in place.
  std::optional<PoseOffset> offset;
  /// At its last used frame; none if the map does not register frames.
  std::optional<PoseErrorEstimate> pose_error;

  friend bool operator==(const RobotState&, const RobotState&) = default;
};

}  // namespace steadymap
