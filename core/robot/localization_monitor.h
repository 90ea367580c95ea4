#pragma once

#include <cstdint>

#include "core/frame/frame.h"
#include "core/map/robot_state.h"
#include "core/robot/pose_consistency.h"
#include "core/working/working_map.h"

namespace steadymap {

/// When a robot is taken for lost. Defaults: measured on the routes of the simulated hall.
struct LocalizationMonitorParameters {
  /// False: every robot is believed, as in the paper.
  bool is_on = true;
  /// A pose further than this from where the motion so far leads is a jump: that much at once, and
  /// so much more for each second since the last frame. Metres.
  double jump_m = 0.2;
  double jump_m_per_s = 0.8;
  /// The same for its direction, radians.
  double jump_rad = 0.14;
  double jump_rad_per_s = 0.7;
  /// After so long without a frame the robot is taken to stand where it stood: if it turns up
  /// elsewhere, it jumped. Seconds.
  double motion_s = 1.0;
  /// Share of the picture that the map must know to say anything. Less says what noise says.
  double min_known_share = 0.05;
  /// Where this share of what is known fits, a frame is at home, wherever else it would fit.
  double sure_share = 0.7;
  /// Where this share fits, a frame may be at home.
  double good_share = 0.5;
  /// A frame that may be at home elsewhere is so if it fits by so much more there than here.
  double better_by_share = 0.2;
  /// Frames in a row that disagree until a doubted robot is lost. They do not count meanwhile.
  std::uint32_t losing_frames = 3;
  /// Frames in a row that agree until a lost robot is found. The last of them counts.
  std::uint32_t finding_frames = 3;
  /// Frames in a row that show nothing the map knows until a lost robot is believed to be somewhere
  /// new. Many, since it may as well have lost its way further.
  std::uint32_t new_place_frames = 30;
  PoseConsistencyParameters views;

  friend bool operator==(const LocalizationMonitorParameters&,
                         const LocalizationMonitorParameters&) = default;
};

/// Decides for each frame whether its robot is where it says, before the frame changes anything.
///
/// A frame alone cannot tell a robot that is lost from a place that was rearranged: in either case
/// it contradicts the map, down to nothing that fits. So a robot that drives on as before is
/// believed whatever it sees, and so is one that is new to the map. Only a jump that its motion
/// does not explain raises doubt, and only evidence against the jump confirms it: the frame fits
/// clearly better where the robot would be without. Such frames disagree, and do not count. After
/// a few in a row the robot is lost. It is found when its frames fit again, when it is back where
/// its motion would have led, or when it sees nothing but what the map does not know.
///
/// What is recognised: a jump between two frames, and a robot that wakes up with a wrong pose where
/// it stopped. What is not: a first pose that is wrong; a slow slide; a jump by less than
/// `jump_m`, by the distance of equal things in a row, or along a bare wall; one out of the map
/// into the unknown, unless the map knows what is seen from where the robot truly is.
///
/// A function of the map and the frame.
class LocalizationMonitor {
 public:
  explicit LocalizationMonitor(const LocalizationMonitorParameters& parameters)
      : parameters_(parameters) {}

  /// Whether the frame counts. Notes the robot's pose in the map, and tells when it is lost or
  /// found. Cost: next to nothing for a robot that is trusted and moves on, else up to 0.5 ms.
  bool Accept(const Frame& frame, const FrameSurface& surface, WorkingMap* map) const;

 private:
  enum class Verdict { kAgrees, kDisagrees, kShowsNewPlace, kSaysNothing };

  bool IsJump(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double elapsed_s) const;
  void FollowMotion(const Frame& frame, RobotState* robot) const;
  Verdict Judge(const FrameSurface& surface, const RobotState& robot, const WorkingMap& map) const;
  bool UpdateTrust(Verdict verdict,
                   const SensorName& name,
                   RobotState* robot,
                   WorkingMap* map) const;

  LocalizationMonitorParameters parameters_;
};

}  // namespace steadymap
