#include "core/robot/localization_monitor.h"

namespace steadymap {
namespace {

// Between frames that are closer there is no telling how fast a robot moves.
constexpr double kMinElapsedS = 0.005;

/// How the camera moved, in its own frame, if `robot` moved on as before.
Eigen::Isometry3d MotionOf(const RobotState& robot, double elapsed_s) {
  return TransformOf(elapsed_s * robot.velocity_m_per_s.cast<double>(),
                     elapsed_s * robot.turn_rad_per_s.cast<double>());
}

}  // namespace

bool LocalizationMonitor::Accept(const Frame& frame,
                                 const FrameSurface& surface,
                                 WorkingMap* map) const {
  if (!parameters_.is_on) return true;
  const RobotState* known = map->FindRobot(frame.source);
  RobotState robot;
  if (known == nullptr) {
    robot.claimed = CameraPlace::FromIsometry(frame.T_world_camera);
    robot.likely = robot.claimed;
  } else {
    robot = *known;
    FollowMotion(frame, &robot);
  }
  robot.last_capture_time = frame.capture_time;
  const bool counts = robot.trust == Trust::kTrusted ||
                      UpdateTrust(Judge(surface, robot, *map), frame.source, &robot, map);
  map->StoreRobot(frame.source, robot);
  return counts;
}

bool LocalizationMonitor::IsJump(const Eigen::Isometry3d& from,
                                 const Eigen::Isometry3d& to,
                                 double elapsed_s) const {
  const double distance_m = (to.translation() - from.translation()).norm();
  const double angle_rad = Eigen::AngleAxisd(from.linear().transpose() * to.linear()).angle();
  return distance_m > parameters_.jump_m + elapsed_s * parameters_.jump_m_per_s ||
         angle_rad > parameters_.jump_rad + elapsed_s * parameters_.jump_rad_per_s;
}

/// Takes in where the robot says that it is now, and where it would be otherwise.
void LocalizationMonitor::FollowMotion(const Frame& frame, RobotState* robot) const {
  const double since_s = (frame.capture_time - robot->last_capture_time).seconds();
  const bool is_moving = since_s >= kMinElapsedS && since_s <= parameters_.motion_s;
  const double elapsed_s = is_moving ? since_s : 0.0;
  const Eigen::Isometry3d T_world_before = robot->claimed.ToIsometry();
  const Eigen::Isometry3d T_before_expected = MotionOf(*robot, elapsed_s);
  const Eigen::Isometry3d T_before_now = T_world_before.inverse() * frame.T_world_camera;
  const bool is_jump = IsJump(T_world_before * T_before_expected, frame.T_world_camera, elapsed_s);
  robot->claimed = CameraPlace::FromIsometry(frame.T_world_camera);
  if (is_jump && robot->trust == Trust::kTrusted) robot->trust = Trust::kDoubted;
  if (robot->trust == Trust::kTrusted) {
    robot->likely = robot->claimed;
  } else {
    robot->likely = CameraPlace::FromIsometry(robot->likely.ToIsometry() *
                                              (is_jump ? T_before_expected : T_before_now));
  }
  if (is_jump) return;
  if (!is_moving) {
    robot->velocity_m_per_s.setZero();
    robot->turn_rad_per_s.setZero();
    return;
  }
  const CameraPlace motion = CameraPlace::FromIsometry(T_before_now);
  robot->velocity_m_per_s = (motion.position_world / elapsed_s).cast<float>();
  robot->turn_rad_per_s = motion.rotation_world / static_cast<float>(elapsed_s);
}

LocalizationMonitor::Verdict LocalizationMonitor::Judge(const FrameSurface& surface,
                                                        const RobotState& robot,
                                                        const WorkingMap& map) const {
  const Eigen::Isometry3d T_world_claimed = robot.claimed.ToIsometry();
  const Eigen::Isometry3d T_world_likely = robot.likely.ToIsometry();
  if (!IsJump(T_world_likely, T_world_claimed, 0.0)) return Verdict::kAgrees;
  const PoseConsistency here = CompareFrame(parameters_.views, surface, T_world_claimed, map);
  const auto min_patches =
      static_cast<std::size_t>(parameters_.min_known_share * static_cast<double>(here.patches));
  const bool is_known = here.comparable() > min_patches;
  const double here_share = is_known ? here.share() : 0.0;
  if (here_share >= parameters_.sure_share) return Verdict::kAgrees;
  // A guess that has left the range of poses is none.
  const PoseConsistency there = T_world_likely.translation().norm() > kMaxPositionM
                                    ? PoseConsistency()
                                    : CompareFrame(parameters_.views, surface, T_world_likely, map);
  if (there.comparable() > min_patches && there.share() >= parameters_.good_share &&
      there.share() >= here_share + parameters_.better_by_share) {
    return Verdict::kDisagrees;
  }
  if (is_known) {
    const bool in_doubt = robot.trust == Trust::kLost || robot.streak > 0;
    return in_doubt && here_share < parameters_.good_share ? Verdict::kDisagrees : Verdict::kAgrees;
  }
  if (here.unknown <= min_patches) return Verdict::kSaysNothing;
  // Where it would be without the jump is a guess that grows old: what speaks against that says
  // nothing for the jump.
  const bool is_guess_void = there.comparable() > min_patches;
  return robot.trust == Trust::kLost && is_guess_void ? Verdict::kSaysNothing
                                                      : Verdict::kShowsNewPlace;
}

/// Draws the consequences; returns whether the frame counts.
bool LocalizationMonitor::UpdateTrust(Verdict verdict,
                                      const SensorName& name,
                                      RobotState* robot,
                                      WorkingMap* map) const {
  const bool was_lost = robot->trust == Trust::kLost;
  if (verdict == Verdict::kSaysNothing) return !was_lost && robot->streak == 0;
  const bool is_against = (verdict == Verdict::kDisagrees) != was_lost;
  robot->streak = is_against ? robot->streak + 1 : 0;
  const std::uint32_t finding_frames = verdict == Verdict::kShowsNewPlace
                                           ? parameters_.new_place_frames
                                           : parameters_.finding_frames;
  if (was_lost && robot->streak < finding_frames) return false;
  if (!was_lost && is_against) {
    if (robot->streak < parameters_.losing_frames) return false;
    robot->trust = Trust::kLost;
    robot->streak = 0;
    map->RecordEvent(map->MakeRobotEvent(EventType::kRobotLost, EventReason::kDisagreement, name));
    return false;
  }
  if (was_lost) {
    map->RecordEvent(map->MakeRobotEvent(EventType::kRobotFound, EventReason::kAgreement, name));
  }
  // From here on its motion is that of the pose it was believed in.
  robot->trust = Trust::kTrusted;
  robot->streak = 0;
  robot->likely = robot->claimed;
  robot->velocity_m_per_s.setZero();
  robot->turn_rad_per_s.setZero();
  return true;
}

}  // namespace steadymap
