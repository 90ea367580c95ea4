#include "client/bench/evaluation/score/pose_score.h"

#include <cmath>

#include <absl/strings/str_format.h>

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

}  // namespace

double PoseScore::rms_m() const { return std::sqrt(square_sum_m2 / static_cast<double>(points)); }

PoseScore& PoseScore::operator+=(const PoseScore& other) {
  square_sum_m2 += other.square_sum_m2;
  points += other.points;
  return *this;
}

std::string MillimetreText(const PoseScore& score) {
  return score.points == 0 ? "-" : absl::StrFormat("%.1f", 1e3 * score.rms_m());
}

PoseScore ScorePoses(const CameraPath& truth, const CameraPath& poses) {
  const auto most = kPointsAPose * static_cast<Eigen::Index>(poses.size());
  Eigen::Matrix3Xd points(3, most);
  Eigen::Matrix3Xd true_points(3, most);
  Eigen::Index count = 0;
  auto true_pose = truth.begin();
  for (const StampedPose& pose : poses) {
    while (true_pose != truth.end() && true_pose->time < pose.time) ++true_pose;
    if (true_pose == truth.end()) break;
    if (true_pose->time != pose.time) continue;
    points.middleCols<kPointsAPose>(count) = PointsOf(pose.T_world_camera);
    true_points.middleCols<kPointsAPose>(count) = PointsOf(true_pose->T_world_camera);
    count += kPointsAPose;
  }
  if (count == 0) return {};
  points.conservativeResize(Eigen::NoChange, count);
  true_points.conservativeResize(Eigen::NoChange, count);
  const Eigen::Isometry3d motion(Eigen::umeyama(points, true_points, /*with_scaling=*/false));
  const Eigen::Matrix3Xd moved = (motion.linear() * points).colwise() + motion.translation();
  return {.square_sum_m2 = (moved - true_points).squaredNorm(),
          .points = static_cast<std::size_t>(count)};
}

}  // namespace steadymap
