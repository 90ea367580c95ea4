#include "core/map/pose_error.h"

#include <cmath>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(PoseError, TurnsACameraAboutItself) {
  PoseError error;
  error.mean << 0.1, 0.2, 0.3, 0.0, 0.0, M_PI / 2.0;
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.translation() = Eigen::Vector3d(5.0, 6.0, 7.0);
  const Eigen::Isometry3d corrected = error.Correct(T_world_camera);
  EXPECT_TRUE(corrected.translation().isApprox(Eigen::Vector3d(5.1, 6.2, 7.3)));
  EXPECT_TRUE(corrected.linear().col(0).isApprox(Eigen::Vector3d::UnitY()));
}

TEST(PoseError, CombinesTheMomentsOfItsHypotheses) {
  PoseErrorEstimate estimate;
  estimate.hypotheses[0].probability = 0.25;
  estimate.hypotheses[1].probability = 0.75;
  estimate.hypotheses[2].probability = 0.0;
  estimate.hypotheses[0].error.mean[1] = 4.0;
  estimate.hypotheses[0].error.covariance(1, 1) = 2.0;
  const PoseError combined = estimate.Combined();
  EXPECT_DOUBLE_EQ(combined.mean[1], 1.0);
  // E[x^2] - E[x]^2 = 0.25 (2 + 16) - 1.
  EXPECT_DOUBLE_EQ(combined.covariance(1, 1), 3.5);
}

TEST(PoseError, MovesWithTheWorld) {
  PoseErrorEstimate estimate;
  for (PoseErrorHypothesis& hypothesis : estimate.hypotheses) {
    hypothesis.error.mean << 0.02, -0.01, 0.03, 0.01, -0.02, 0.03;
  }
  const Eigen::Isometry3d T_world_camera =
      Eigen::Translation3d(1.0, 2.0, 0.5) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY());
  const Eigen::Isometry3d motion =
      Eigen::Translation3d(0.05, 0.0, -0.01) * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ());
  const Eigen::Isometry3d expected = motion * estimate.Combined().Correct(T_world_camera);
  estimate.Move(motion, T_world_camera.translation());
  EXPECT_TRUE(estimate.Combined().Correct(T_world_camera).isApprox(expected, 1e-12));
}

}  // namespace
}  // namespace steadymap
