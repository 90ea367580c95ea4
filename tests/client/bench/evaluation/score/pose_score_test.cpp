#include "client/bench/evaluation/score/pose_score.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// A drive along an arc, one pose a second.
CameraPath Arc(int count) {
  CameraPath path;
  for (int i = 0; i < count; ++i) {
    StampedPose& pose = path.emplace_back();
    pose.time = Timestamp::FromSeconds(i);
    pose.T_world_camera =
        Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(2.0, 0.0, 0.0);
  }
  return path;
}

TEST(ScorePoses, AMotionOfAllPosesIsNoError) {
  const CameraPath truth = Arc(20);
  CameraPath moved = truth;
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(1.0, -2.0, 0.5) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX());
  for (StampedPose& pose : moved) pose.T_world_camera = motion * pose.T_world_camera;
  const PoseScore score = ScorePoses(truth, moved);
  EXPECT_EQ(score.points, 60U);
  EXPECT_LT(score.rms_m(), 1e-9);
}

TEST(ScorePoses, AlternatingShiftsCountInFull) {
  const CameraPath truth = Arc(200);
  CameraPath shifted = truth;
  for (std::size_t i = 0; i < shifted.size(); ++i) {
    shifted[i].T_world_camera.translation().z() += i % 2 == 0 ? 0.01 : -0.01;
  }
  EXPECT_NEAR(ScorePoses(truth, shifted).rms_m(), 0.01, 1e-4);
}

TEST(ScorePoses, ATurnedCameraCountsByWhatItSees) {
  const CameraPath truth = Arc(200);
  CameraPath turned = truth;
  constexpr double kTurnRad = 0.01;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    turned[i].T_world_camera.rotate(
        Eigen::AngleAxisd(i % 2 == 0 ? kTurnRad : -kTurnRad, Eigen::Vector3d::UnitZ()));
  }
  // A turn about the optical axis displaces only the point 1 m beside it.
  EXPECT_NEAR(ScorePoses(truth, turned).rms_m(), kTurnRad / std::numbers::sqrt3, 1e-4);
}

TEST(ScorePoses, ErrorsCountInTheStandardDeviationsStatedForThem) {
  const CameraPath truth = Arc(200);
  CameraPath estimated = truth;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Identity();
  covariance.topLeftCorner<3, 3>() *= 0.01 * 0.01;
  covariance.bottomRightCorner<3, 3>() *= 0.002 * 0.002;
  estimated[0].covariance = covariance;
  for (std::size_t i = 1; i < estimated.size(); ++i) {
    // Two standard deviations in each coordinate: of the shift, and of the turn about each axis.
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    const Eigen::Vector3d turn = sign * 0.004 * Eigen::Vector3d::Ones();
    Eigen::Isometry3d& pose = estimated[i].T_world_camera;
    pose.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * pose.linear();
    pose.translation() += sign * 0.02 * Eigen::Vector3d::Ones();
    estimated[i].covariance = covariance;
  }
  const PoseScore score = ScorePoses(truth, estimated);
  EXPECT_EQ(score.stated_poses, 200U);
  EXPECT_NEAR(score.rms_sigmas(), 2.0, 0.02);
  EXPECT_EQ(SigmaText(score), "2.0");
}

TEST(ScorePoses, OnlyPosesWithTheTimesOfTheTruthCount) {
  const CameraPath truth = Arc(20);
  const auto far_off = [](double time_s) {
    return StampedPose{Timestamp::FromSeconds(time_s), Eigen::Isometry3d::Identity()};
  };
  const CameraPath some = {
      far_off(-1.0), truth[3], truth[4], far_off(8.5), truth[9], far_off(99.0)};
  const PoseScore score = ScorePoses(truth, some);
  EXPECT_EQ(score.points, 9U);
  EXPECT_LT(score.rms_m(), 1e-9);
}

TEST(ScorePoses, WithoutPosesThereIsNoScore) {
  const PoseScore score = ScorePoses(Arc(3), {});
  EXPECT_TRUE(std::isnan(score.rms_m()));
  EXPECT_EQ(MillimetreText(score), "-");
  EXPECT_EQ(SigmaText(score), "-");
}

TEST(PoseScore, TheSumOfRunsWeighsThemByTheirPoints) {
  PoseScore score{.square_sum_m2 = 0.0, .points = 3};
  score += {.square_sum_m2 = 0.04, .points = 1};
  EXPECT_DOUBLE_EQ(score.rms_m(), 0.1);
  EXPECT_EQ(MillimetreText(score), "100.0");
}

}  // namespace
}  // namespace steadymap
