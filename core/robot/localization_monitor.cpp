#include "core/robot/localization_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace steadymap {
namespace {

// Between frames that are closer there is no telling how fast a robot moves.
constexpr double kMinElapsedS = 0.005;

// A turn displaces what is this far away.
constexpr double kLeverM = 1.0;

/// How the camera moved, in its own frame, if `robot` moved on as before.
Eigen::Isometry3d MotionOf(const RobotState& robot, double elapsed_s) {
  return TransformOf(elapsed_s * robot.velocity_m_per_s.cast<double>(),
                     elapsed_s * robot.turn_rad_per_s.cast<double>());
}

/// The ratio of the odds of two poses that decides between them, as a logarithm.
double DecisiveLogOdds(const LocalizationMonitorParameters& parameters) {
  return std::log((1.0 - parameters.error_share) / parameters.error_share);
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
  const double elapsed_s =
      known == nullptr ? 0.0 : (frame.capture_time - known->last_capture_time).seconds();
  robot.last_capture_time = frame.capture_time;
  bool counts = true;
  if (robot.trust != Trust::kTrusted) {
    UpdateOdds(surface, elapsed_s, *map, &robot);
    counts = UpdateTrust(frame.source, &robot, map);
  }
  map->StoreRobot(frame.source, robot);
  return counts;
}

/// True if a robot that moved on without jumps would be where it says.
bool LocalizationMonitor::AreSamePlace(const RobotState& robot) const {
  return !IsJump(robot.likely.ToIsometry(), robot.claimed.ToIsometry(), 0.0);
}

bool LocalizationMonitor::IsJump(const Eigen::Isometry3d& from,
                                 const Eigen::Isometry3d& to,
                                 double elapsed_s) const {
  const double distance_m = (to.translation() - from.translation()).norm();
  const double angle_rad = Eigen::AngleAxisd(from.linear().transpose() * to.linear()).angle();
  return std::max(distance_m, kLeverM * angle_rad) >
         parameters_.jump_m + elapsed_s * parameters_.jump_m_per_s;
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
  if (is_jump) {
    // What was seen from the pose before says nothing for this one.
    robot->claimed_log_odds = 0.0F;
    if (robot->trust == Trust::kTrusted) robot->trust = Trust::kDoubted;
  }
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

/// Adds what a frame says to the log-odds of the claimed and the likely pose.
void LocalizationMonitor::UpdateOdds(const FrameSurface& surface,
                                     double elapsed_s,
                                     const WorkingMap& map,
                                     RobotState* robot) const {
  const double look_share = std::min(1.0, std::abs(elapsed_s) / parameters_.look_s);
  const double new_place_log_odds = std::log(parameters_.new_place_odds);
  const double least = std::log(parameters_.rearranged_share);
  const double most = DecisiveLogOdds(parameters_);
  const auto update = [&](const CameraPlace& place, double new_place, float* log_odds) {
    const Eigen::Isometry3d T_world_camera = place.ToIsometry();
    // A guess that has left the range of poses is none.
    const double ratio =
        T_world_camera.translation().norm() > kMaxPositionM
            ? least
            : LogLikelihoodRatio(CompareFrame(parameters_.views, surface, T_world_camera, map),
                                 new_place);
    *log_odds = static_cast<float>(
        std::clamp(static_cast<double>(*log_odds) + look_share * ratio, least, most));
  };
  if (AreSamePlace(*robot)) {
    robot->claimed_log_odds = std::max(robot->claimed_log_odds, robot->likely_log_odds);
    update(robot->claimed, new_place_log_odds, &robot->claimed_log_odds);
    robot->likely_log_odds = robot->claimed_log_odds;
  } else {
    update(robot->claimed, new_place_log_odds, &robot->claimed_log_odds);
    // A guess grows old where nothing confirms it.
    update(robot->likely, -new_place_log_odds, &robot->likely_log_odds);
  }
}

/// Returns the log of the ratio of the probabilities of a look if its pose is right and if it is
/// wrong.
double LocalizationMonitor::LogLikelihoodRatio(const PoseConsistency& view,
                                               double new_place_log_odds) const {
  const double fit = std::log(parameters_.fit_if_right / parameters_.fit_if_wrong);
  const double contradiction =
      std::log((1.0 - parameters_.fit_if_right) / (1.0 - parameters_.fit_if_wrong));
  return (static_cast<double>(view.fitting) * fit +
          static_cast<double>(view.contradicting) * contradiction +
          static_cast<double>(view.unknown) * new_place_log_odds) /
         static_cast<double>(std::max<std::size_t>(view.patches, 1));
}

/// Decides by the log-odds; returns whether the frame counts.
bool LocalizationMonitor::UpdateTrust(const SensorName& name,
                                      RobotState* robot,
                                      WorkingMap* map) const {
  const bool was_lost = robot->trust == Trust::kLost;
  const float gain = robot->claimed_log_odds - robot->likely_log_odds;
  if (was_lost) {
    if (gain < 0.0F || robot->claimed_log_odds <= 0.0F) return false;
    map->RecordEvent(map->MakeRobotEvent(EventType::kRobotFound, EventReason::kAgreement, name));
  } else if (!AreSamePlace(*robot)) {
    const auto decisive = static_cast<float>(DecisiveLogOdds(parameters_));
    if (gain <= -decisive) {
      robot->trust = Trust::kLost;
      map->RecordEvent(
          map->MakeRobotEvent(EventType::kRobotLost, EventReason::kDisagreement, name));
      return false;
    }
    const bool is_settled =
        gain >= decisive || (gain >= 0.0F && robot->claimed_log_odds >= decisive);
    if (!is_settled) return gain >= 0.0F || robot->likely_log_odds <= 0.0F;
  }
  // From here on its motion is that of the pose it was believed in.
  robot->trust = Trust::kTrusted;
  robot->claimed_log_odds = 0.0F;
  robot->likely_log_odds = 0.0F;
  robot->likely = robot->claimed;
  robot->velocity_m_per_s.setZero();
  robot->turn_rad_per_s.setZero();
  return true;
}

}  // namespace steadymap
