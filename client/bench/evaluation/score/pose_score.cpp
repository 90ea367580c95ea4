#include "client/bench/evaluation/score/pose_score.h"

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <absl/strings/str_format.h>

#include "core/map/pose_error.h"

namespace steadymap {
namespace {

constexpr double kDepthM = 2.0;
constexpr double kAsideM = 1.0;
constexpr Eigen::Index kPointsAPose = 3;

/// Returns the points of a pose as columns, world frame.
Eigen::Matrix3d PointsOf(const Eigen::Isometry3d& T_world_camera) {
  Eigen::Matrix3d points_camera;
  points_camera.col(0) = Eigen::Vector3d::Zero();
  points_camera.col(1) = Eigen::Vector3d(0.0, 0.0, kDepthM);
  points_camera.col(2) = Eigen::Vector3d(kAsideM, 0.0, kDepthM);
  return (T_world_camera.linear() * points_camera).colwise() + T_world_camera.translation();
}

/// Returns the square of the Mahalanobis distance of a pose from the true one.
double SquareDistanceSigmas2(const Eigen::Isometry3d& T_world_camera,
                             const Eigen::Isometry3d& T_world_true,
                             const Eigen::Matrix<double, 6, 6>& covariance) {
  const Eigen::AngleAxisd turn(T_world_true.linear() * T_world_camera.linear().transpose());
  PoseErrorVector error;
  error << T_world_true.translation() - T_world_camera.translation(), turn.angle() * turn.axis();
  return error.dot(covariance.llt().solve(error));
}

}  // namespace

double PoseScore::rms_m() const { return std::sqrt(square_sum_m2 / static_cast<double>(points)); }

double PoseScore::rms_sigmas() const {
  return std::sqrt(square_sum_sigmas2 / static_cast<double>(6 * stated_poses));
}

PoseScore& PoseScore::operator+=(const PoseScore& other) {
  square_sum_m2 += other.square_sum_m2;
  points += other.points;
  square_sum_sigmas2 += other.square_sum_sigmas2;
  stated_poses += other.stated_poses;
  return *this;
}

std::string MillimetreText(const PoseScore& score) {
  return score.points == 0 ? "-" : absl::StrFormat("%.1f", 1e3 * score.rms_m());
}

std::string SigmaText(const PoseScore& score) {
  return score.stated_poses == 0 ? "-" : absl::StrFormat("%.1f", score.rms_sigmas());
}

PoseScore ScorePoses(const CameraPath& truth, const CameraPath& poses) {
  const auto most = kPointsAPose * static_cast<Eigen::Index>(poses.size());
  Eigen::Matrix3Xd points(3, most);
  Eigen::Matrix3Xd true_points(3, most);
  Eigen::Index count = 0;
  std::vector<std::pair<const StampedPose*, const StampedPose*>> stated;  // The true one second.
  auto true_pose = truth.begin();
  for (const StampedPose& pose : poses) {
    while (true_pose != truth.end() && true_pose->time < pose.time) ++true_pose;
    if (true_pose == truth.end()) break;
    if (true_pose->time != pose.time) continue;
    points.middleCols<kPointsAPose>(count) = PointsOf(pose.T_world_camera);
    true_points.middleCols<kPointsAPose>(count) = PointsOf(true_pose->T_world_camera);
    count += kPointsAPose;
    if (pose.covariance) stated.emplace_back(&pose, &*true_pose);
  }
  if (count == 0) return {};
  points.conservativeResize(Eigen::NoChange, count);
  true_points.conservativeResize(Eigen::NoChange, count);
  const Eigen::Isometry3d motion(Eigen::umeyama(points, true_points, /*with_scaling=*/false));
  const Eigen::Matrix3Xd moved = (motion.linear() * points).colwise() + motion.translation();
  PoseScore score;
  score.square_sum_m2 = (moved - true_points).squaredNorm();
  score.points = static_cast<std::size_t>(count);
  score.stated_poses = stated.size();
  if (stated.empty()) return score;
  const Eigen::Isometry3d T_map_world =
      stated.front().first->T_world_camera * stated.front().second->T_world_camera.inverse();
  for (const auto& [pose, true_stated] : stated) {
    score.square_sum_sigmas2 += SquareDistanceSigmas2(
        pose->T_world_camera, T_map_world * true_stated->T_world_camera, *pose->covariance);
  }
  return score;
}

}  // namespace steadymap
