#include "client/bench/evaluation/composite/upright.h"

#include <random>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(UprightRotation, TurnsMostLevelSurfaceUp) {
  const Eigen::Quaternionf tilt(Eigen::AngleAxisf(0.47F, Eigen::Vector3f(0.6F, 0.8F, 0.0F)));
  std::mt19937_64 random(3);
  std::normal_distribution<float> noise(0.0F, 0.03F);
  std::vector<Eigen::Vector3f> normals;
  for (int i = 0; i < 3000; ++i) {
    const Eigen::Vector3f level(noise(random), noise(random), 1.0F);
    const Eigen::Vector3f wall(1.0F, noise(random), noise(random));
    const Eigen::Vector3f ramp(0.5F + noise(random), noise(random), 1.0F);
    normals.push_back(tilt * level.normalized());
    normals.push_back(tilt * wall.normalized());
    if (i % 3 == 0) normals.push_back(tilt * ramp.normalized());
  }
  const Eigen::Vector3d up =
      UprightRotation(normals) * (tilt * Eigen::Vector3f::UnitZ()).cast<double>();
  EXPECT_GT(up.z(), 0.9998);
}

TEST(UprightRotation, IsTheIdentityWithoutLevelSurface) {
  EXPECT_TRUE(UprightRotation({}).isApprox(Eigen::Quaterniond::Identity()));
  EXPECT_TRUE(UprightRotation({Eigen::Vector3f::UnitX(), -Eigen::Vector3f::UnitZ()})
                  .isApprox(Eigen::Quaterniond::Identity()));
}

}  // namespace
}  // namespace steadymap
