#include "core/integration/semantic_cloud.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_depth.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::RenderScene;

constexpr std::uint16_t kWall = 4;
constexpr std::uint16_t kGoods = 7;
constexpr std::uint16_t kPerson = 13;
constexpr std::uint16_t kPersonInstance = 21;

/// Returns a frame of a person in front of a wall. The person has an instance id, and the class of
/// its upper part is goods.
Frame PersonWithSpot(double goods_share) {
  Frame frame = RenderScene({Body(kWall, {3.0, -4.0, -4.0}, {3.2, 4.0, 4.0}),
                             Body(kPerson, {1.8, -0.4, -0.8}, {2.0, 0.4, 0.8})},
                            {});
  frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
  int first = frame.camera.height_px;
  int last = 0;
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      if (frame.labels.At(u, v) != kPerson) continue;
      frame.instances.At(u, v) = kPersonInstance;
      first = std::min(first, v);
      last = std::max(last, v);
    }
  }
  for (int v = first; v < first + static_cast<int>(goods_share * (last - first)); ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      if (frame.labels.At(u, v) == kPerson) frame.labels.At(u, v) = kGoods;
    }
  }
  return frame;
}

std::size_t CountFused(const SemanticCloud& cloud, std::uint16_t instance, std::uint16_t label) {
  std::size_t count = 0;
  for (int row = 0; row < cloud.cells_high(); ++row) {
    for (int column = 0; column < cloud.cells_wide(); ++column) {
      count += cloud.InstanceAt(column, row) == instance && cloud.LabelAt(column, row) == label &&
                       cloud.At(column, row).weight > 0.0F
                   ? 1U
                   : 0U;
    }
  }
  return count;
}

TEST(SemanticCloud, ASpotOfAnotherClassOnAMovingThingIsNotFused) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(PersonWithSpot(0.3));
  EXPECT_EQ(CountFused(cloud, kPersonInstance, kGoods), 0U);
  EXPECT_EQ(CountFused(cloud, kPersonInstance, kPerson), 0U);
  EXPECT_GT(CountFused(cloud, 0, kWall), 500U);
}

TEST(SemanticCloud, AThingOfWhichLessThanHalfMovesIsFusedButForThat) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(PersonWithSpot(0.8));
  EXPECT_GT(CountFused(cloud, kPersonInstance, kGoods), 100U);
  EXPECT_EQ(CountFused(cloud, kPersonInstance, kPerson), 0U);
}

/// Returns a frame of a wall at `depth_m` from a camera of a declared kind, with noise.
Frame NoisyWall(double depth_m, double noise_share, DepthSensorKind sensor) {
  Frame frame = testing::RenderAnalytic(testing::Plane({0.0, 0.0, 1.0}, depth_m),
                                        testing::AnalyticCamera(),
                                        Eigen::Isometry3d::Identity());
  frame.depth.sensor = sensor;
  testing::AddNoise([&](double z_m) { return noise_share * z_m; }, 7, &frame.depth);
  return frame;
}

TEST(SemanticCloud, ACameraCanBeNoisierThanItsKind) {
  SemanticCloud cloud{MapConfig()};
  const double typical_m = NoiseOf(DepthSensorKind::kStereo).SigmaM(2.0);
  cloud.Compute(NoisyWall(2.0, 0.001, DepthSensorKind::kStereo));
  EXPECT_EQ(cloud.depth_noise().SigmaM(2.0), typical_m);
  cloud.Compute(NoisyWall(2.0, 0.02, DepthSensorKind::kStereo));
  EXPECT_NEAR(cloud.depth_noise().SigmaM(2.0), 0.04, 0.004);
}

MapConfig SmallVoxels() {
  MapConfig config;
  config.voxel_size_m = 0.01;
  config.truncation_m = DefaultTruncationM(config.voxel_size_m);
  config.max_depth_m = 5.0;
  return config;
}

TEST(SemanticCloud, ANoisyPlaneIsFusedInMapsOfSmallVoxels) {
  const MapConfig config = SmallVoxels();
  SemanticCloud cloud{config};
  cloud.Compute(NoisyWall(4.0, 0.01, DepthSensorKind::kStereo));
  ASSERT_GT(cloud.depth_noise().SigmaM(4.0), config.truncation_m);
  const std::size_t cells =
      static_cast<std::size_t>(cloud.cells_wide()) * static_cast<std::size_t>(cloud.cells_high());
  EXPECT_GT(CountFused(cloud, 0, 0), cells * 9 / 10);
}

TEST(SemanticCloud, ANoisyCellOnNoPlaneIsFusedOnlyIfItsNoiseFitsTheVoxels) {
  Frame frame;
  frame.camera = testing::AnalyticCamera();
  frame.depth.units = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
  frame.depth.sensor = DepthSensorKind::kStereo;
  const int u = frame.camera.width_px / 4 * 2;
  const int v = frame.camera.height_px / 4 * 2;
  for (int row = v; row < v + 2; ++row) {
    for (int column = u; column < u + 2; ++column) frame.depth.units.At(column, row) = 3000;
  }
  SemanticCloud fine{SmallVoxels()};
  fine.Compute(frame);
  EXPECT_EQ(CountFused(fine, 0, 0), 0U);
  MapConfig config;
  config.max_depth_m = 5.0;
  SemanticCloud coarse{config};
  coarse.Compute(frame);
  EXPECT_EQ(CountFused(coarse, 0, 0), 1U);
}

TEST(SemanticCloud, WithoutInstancesASpotIsWhatItsLabelSays) {
  Frame frame = PersonWithSpot(0.3);
  frame.instances = {};
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  EXPECT_GT(CountFused(cloud, 0, kGoods), 50U);
}

}  // namespace
}  // namespace steadymap
