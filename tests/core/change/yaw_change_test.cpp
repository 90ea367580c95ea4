#include "core/change/yaw_change.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// Returns the observations of a flat front of `width_m` along y, 1 m high, facing -x, rotated
/// about its centre and then shifted. Points are 5 cm apart. Each distance has noise of standard
/// deviation `noise_m`.
YawChangeSum LookAtFront(double width_m,
                         double turn_rad,
                         const Eigen::Vector3d& shift,
                         double noise_m) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, noise_m);
  const Eigen::Vector3d middle(3.0, -2.0, 0.5);
  const Eigen::Vector3d normal = -Eigen::Vector3d::UnitX();
  YawChangeSum sum;
  constexpr double kStepM = 0.05;
  const auto half_steps = static_cast<int>(std::lround(0.5 * width_m / kStepM));
  for (int column = -half_steps; column <= half_steps; ++column) {
    for (int row = -10; row <= 10; ++row) {
      const double y = column * kStepM;
      const double z = row * kStepM;
      // Offset of the rotated front along the normal of the unrotated front.
      const double offset_m = y * std::tan(turn_rad) + normal.dot(shift) + noise(random);
      sum.Add(middle + Eigen::Vector3d(0.0, y, z), normal, offset_m);
    }
  }
  return sum;
}

TEST(YawChangeSum, FindsTheTurnOfAFlatFront) {
  for (const double turn_rad : {-0.2, 0.0, 0.05, 0.15}) {
    const YawChangeSum::Turn turn =
        LookAtFront(0.8, turn_rad, Eigen::Vector3d::Zero(), 0.02).Estimate();
    EXPECT_NEAR(turn.angle_rad, turn_rad, 0.02);
    EXPECT_LT(turn.error_rad, 0.02);
  }
}

TEST(YawChangeSum, IsNotMovedByAShift) {
  const YawChangeSum::Turn turn =
      LookAtFront(0.8, 0.15, Eigen::Vector3d(0.05, 0.3, -0.1), 0.0).Estimate();
  EXPECT_NEAR(turn.angle_rad, 0.15, 0.005);
}

TEST(YawChangeSum, KnowsLittleOfWhatIsNarrow) {
  const YawChangeSum narrow = LookAtFront(0.1, 0.2, Eigen::Vector3d::Zero(), 0.0);
  EXPECT_GT(narrow.Estimate().error_rad, 0.1);
  EXPECT_FALSE(narrow.Exceeds(YawChangeParameters()));
  EXPECT_GT(YawChangeSum().Estimate().error_rad, 100.0);
  EXPECT_FALSE(YawChangeSum().Exceeds(YawChangeParameters()));
}

TEST(YawChangeSum, LearnsNothingFromFlatSurface) {
  YawChangeSum sum;
  for (int i = 0; i < 100; ++i) sum.Add({0.1 * i, 0.0, 0.0}, Eigen::Vector3d::UnitZ(), 0.05);
  EXPECT_GT(sum.Estimate().error_rad, 100.0);
}

TEST(YawChangeSum, KnowsHowFarTheTurnMovesTheSurface) {
  // Columns of 17 points from -0.4 to 0.4 m. The rotation moves each point in proportion to its
  // distance from the centre.
  const YawChangeSum::Turn turn =
      LookAtFront(0.8, 0.15, Eigen::Vector3d(0.1, 0.0, 0.0), 0.0).Estimate();
  EXPECT_NEAR(turn.offset_m, std::tan(0.15) * 0.05 * std::sqrt(24.0), 1e-3);
  EXPECT_EQ(YawChangeSum().Estimate().offset_m, 0.0);
}

TEST(YawChangeSum, ExceedsNothingIfItMovesTheSurfaceTooLittle) {
  const YawChangeSum sum = LookAtFront(0.8, 0.15, Eigen::Vector3d::Zero(), 0.01);
  EXPECT_TRUE(sum.Exceeds({.turned_rad = 0.1, .max_error_rad = 0.05, .min_offset_m = 0.03}));
  EXPECT_FALSE(sum.Exceeds({.turned_rad = 0.1, .max_error_rad = 0.05, .min_offset_m = 0.04}));
}

TEST(YawChangeSum, ExceedsWhatPoseErrorExplains) {
  const YawChangeSum sum = LookAtFront(0.8, 0.15, Eigen::Vector3d::Zero(), 0.01);
  EXPECT_TRUE(sum.Exceeds({.turned_rad = 0.1, .max_error_rad = 0.05}));
  EXPECT_FALSE(sum.Exceeds({.turned_rad = 0.2, .max_error_rad = 0.05}));
  EXPECT_FALSE(sum.Exceeds({.turned_rad = 0.1, .max_error_rad = 0.001}));
  EXPECT_FALSE(sum.Exceeds({.turned_rad = 0.0, .max_error_rad = 0.05})) << "never";
}

}  // namespace
}  // namespace steadymap
