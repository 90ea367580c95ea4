#include "core/integration/noise_scale.h"

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
  testing::AddNoise(
      [&](double depth_m) { return scale * kTestedNoise.SigmaM(depth_m); }, 3, &depth);
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
