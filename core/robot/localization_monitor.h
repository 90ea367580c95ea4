#pragma once

#include "core/frame/frame.h"
#include "core/map/robot_state.h"
#include "core/robot/pose_consistency.h"
#include "core/working/working_map.h"

namespace steadymap {

/// When a robot is taken for lost. Defaults: measured on the routes of the simulated hall.
struct LocalizationMonitorParameters {
  /// False: every robot is believed, as in the paper.
  bool is_on = true;
  /// A pose that displaces the camera, or what is 1 m away from it, by more than this from where
  /// the motion so far leads is a jump: so much at once, and so much more for each second since the
  /// last frame. Metres.
  double jump_m = 0.15;
  double jump_m_per_s = 0.8;
  /// After so long without a frame the robot is taken to stand where it stood: if it turns up
  /// elsewhere, it jumped. Seconds.
  double motion_s = 1.0;
  /// Probability that surface where the map knows something fits it, if the pose is right, and if
  /// it is wrong by a jump. Measured in the hall and the 7-Scenes kitchen: 0.79 to 0.89, and 0.02
  /// to 0.15 for 0.4 to 1 m and 0.3 to 0.8 radians.
  double fit_if_right = 0.8;
  double fit_if_wrong = 0.1;
  /// Odds of the stated pose against any other if all surface in view is where the map knows
  /// nothing. Near 1, since a robot that is lost may as well have lost its way further.
  double new_place_odds = 1.15;
  /// Frames within this time tell as much as one of them, seconds.
  double look_s = 0.15;
  /// Probability that a place was rearranged so much that it contradicts a right pose.
  double rearranged_share = 0.1;
  /// A doubted robot is lost or trusted where the error of that decision has this probability.
  double error_share = 0.01;
  PoseConsistencyParameters views;

  friend bool operator==(const LocalizationMonitorParameters&,
                         const LocalizationMonitorParameters&) = default;
};

/// Decides for each frame whether its robot is where it says, before the frame changes anything.
///
/// A frame alone cannot tell a robot that is lost from a place that was rearranged: in either case
/// it contradicts the map, down to nothing that fits. So a robot that drives on as before is
/// believed whatever it sees, and so is one that is new to the map. Only a jump that its motion
/// does not explain raises doubt. From then on two poses are compared: the claimed one, and the
/// likely one, where the robot would be without the jump. Each has log-odds against any other
/// place, and each look adds the log of its likelihood ratio: the mean over the patches of the
/// picture, so that a look has the weight of one independent patch. A frame does not count while
/// the likely pose has better odds than the claimed one and than any other place. The ratio of both
/// decides whether the robot is lost or trusted (sequential test; Wald, "Sequential tests of
/// statistical hypotheses", 1945). A lost robot is found when the claimed pose has the best odds.
///
/// The log-odds are bounded: from below since a place may have been rearranged, so that no
/// contradiction refutes a pose; from above since a robot can lose its way at any time.
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
  bool IsJump(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double elapsed_s) const;
  bool AreSamePlace(const RobotState& robot) const;
  void FollowMotion(const Frame& frame, RobotState* robot) const;
  void UpdateOdds(const FrameSurface& surface,
                  double elapsed_s,
                  const WorkingMap& map,
                  RobotState* robot) const;
  double LogLikelihoodRatio(const PoseConsistency& view, double new_place_log_odds) const;
  bool UpdateTrust(const SensorName& name, RobotState* robot, WorkingMap* map) const;

  LocalizationMonitorParameters parameters_;
};

}  // namespace steadymap
