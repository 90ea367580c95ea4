#include "core/integration/noise_scale.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/analytic_depth.h"

namespace steadymap {
namespace {

constexpr DepthNoise kTestedNoise = {0.001, 0.0025};

/// Returns the depth of a wall at an angle, with Gaussian noise of `scale` times `kTestedNoise`.
DepthImage NoisyWall(double scale) {
  DepthImage depth = testing::RenderAnalytic(testing::Plane({0.4, 0.0, 1.0}, 2.0),
                                             testing::AnalyticCamera(),
                                             Eigen::Isometry3d::Identity())
                         .depth;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < depth.units.size(); ++i) {
    std::uint16_t& units = depth.units.data()[i];
    const double depth_m = units * depth.metres_per_unit;
    const double noisy_m = depth_m + scale * kTestedNoise.SigmaM(depth_m) * normal(random);
    units = static_cast<std::uint16_t>(std::lround(noisy_m / depth.metres_per_unit));
  }
  return depth;
}

TEST(NoiseScaleTest, MeasuresGaussianNoise) {
  for (const double scale : {0.5, 1.0, 4.0}) {
    EXPECT_NEAR(MeasureNoiseScale(NoisyWall(scale), kTestedNoise), scale, 0.1 * scale);
  }
}

TEST(NoiseScaleTest, APlaneHasNone) {
  EXPECT_LT(MeasureNoiseScale(NoisyWall(0.0), kTestedNoise), 0.02);
}

TEST(NoiseScaleTest, IsZeroWithoutDepths) {
  DepthImage depth = NoisyWall(0.0);
  for (std::size_t i = 0; i < depth.units.size(); ++i) depth.units.data()[i] = 0;
  EXPECT_EQ(MeasureNoiseScale(depth, kTestedNoise), 0.0);
}

}  // namespace
}  // namespace steadymap
