#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/cell_index.h"
#include "core/types/timestamp.h"

namespace steadymap {

/// How far a map believes where a robot says that it is.
enum class Trust {
  kTrusted,  ///< Its frames count.
  kDoubted,  ///< It came to its place in a way that nothing explains; its frames must fit.
  kLost,     ///< They did not, again and again; none counts.
};

/// Where a camera is, for the record: in single precision but for the position.
struct CameraPlace {
  Eigen::Vector3d position_world = Eigen::Vector3d::Zero();  ///< Metres.
  /// From the camera frame to the world: axis times angle, radians.
  Eigen::Vector3f rotation_world = Eigen::Vector3f::Zero();

  friend bool operator==(const CameraPlace&, const CameraPlace&) = default;
};

/// Where a robot saw surface of a dynamic class.
struct MovingCell {
  CellIndex cell;             ///< As of `MapSnapshot::free_space`, world frame.
  Timestamp seen;             ///< Capture time of the last frame that saw it.
  bool is_confirmed = false;  ///< Whether a frame shortly before had seen it, too.

  friend bool operator==(const MovingCell&, const MovingCell&) = default;
};

/// What a map remembers of a robot: to notice when it is lost (`localization_monitor.h`), and what
/// moves before its camera (`dynamic_mask.h`).
struct RobotState {
  Trust trust = Trust::kTrusted;
  /// Frames in a row against the trust as it is: that disagree while it is doubted, that agree
  /// while it is lost. 0 while it is trusted.
  std::uint32_t streak = 0;
  Timestamp last_capture_time;  ///< Of its last frame, used or not.
  CameraPlace claimed;          ///< Where that frame says that it was taken.
  /// Where it was taken if the robot only moved, and never jumped, since it was trusted last.
  /// `claimed` while it is trusted.
  CameraPlace likely;
  /// Of the last motion that was believed, camera frame; the turn is axis times rate.
  Eigen::Vector3f velocity_m_per_s = Eigen::Vector3f::Zero();
  Eigen::Vector3f turn_rad_per_s = Eigen::Vector3f::Zero();
  std::vector<MovingCell> moving;  ///< By rising cell, none twice.

  friend bool operator==(const RobotState&, const RobotState&) = default;
};

}  // namespace steadymap
