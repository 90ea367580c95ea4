// Boxes in front of a wall, seen by a camera that looks along x.

#include "core/association/gaps.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneBody;
using ::steadymap::testing::SceneLook;

constexpr double kFrontM = 1.5;
constexpr double kHalfHeightM = 1.5;  // Beyond the image.

SceneBody WallBehind() { return Body(kWallClass, {2.6, -4.0, -4.0}, {2.8, 4.0, 4.0}); }

SceneBody BoxBetween(double left_m, double right_m, std::uint16_t label = kGoodsClass) {
  return Body(label, {kFrontM, left_m, -kHalfHeightM}, {kFrontM + 0.4, right_m, kHalfHeightM});
}

/// Two boxes beside each other, with a gap of `width_m` around y = 0.
Scene BoxesApart(double width_m) {
  return {WallBehind(), BoxBetween(-0.5, -0.5 * width_m), BoxBetween(0.5 * width_m, 0.5)};
}

std::vector<GapInView> FindIn(const Frame& frame) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  return FindGaps(cloud, GapParameters());
}

std::vector<GapInView> FindIn(const Scene& scene, const SceneLook& look = {}) {
  return FindIn(RenderScene(scene, look));
}

TEST(FindGaps, AGapIsSeenBetweenTwoBoxes) {
  const double width_m = 0.1;
  const std::vector<GapInView> gaps = FindIn(BoxesApart(width_m));
  ASSERT_GT(gaps.size(), 20U);
  double lowest_m = 0.0;
  double highest_m = 0.0;
  for (const GapInView& gap : gaps) {
    EXPECT_NEAR(gap.middle_world.x(), kFrontM, 0.01);
    EXPECT_NEAR(gap.middle_world.y(), 0.0, 0.02);
    EXPECT_NEAR(gap.width_m, width_m, 0.04);
    EXPECT_GT(gap.view_world.x(), 0.99);
    // The ray goes on to the wall, 1.1 m behind.
    EXPECT_NEAR(gap.max_angle_rad, width_m / 1.1, 0.04);
    lowest_m = std::min(lowest_m, gap.middle_world.z());
    highest_m = std::max(highest_m, gap.middle_world.z());
  }
  EXPECT_LT(lowest_m, -0.4);
  EXPECT_GT(highest_m, 0.4);
}

TEST(FindGaps, AGapSeenFromTheSideTellsLessOfItsDirection) {
  const auto best_angle = [](double side_m) {
    const SceneLook look = {{0.0, side_m, 0.0}, {kFrontM, 0.0, 0.0}};
    double best_rad = 10.0;
    for (const GapInView& gap : FindIn(BoxesApart(0.2), look)) {
      best_rad = std::min(best_rad, gap.max_angle_rad);
    }
    return best_rad;
  };
  EXPECT_LT(best_angle(0.0), 0.25);
  EXPECT_GT(best_angle(1.0), 0.3);
}

TEST(FindGaps, ABoxHasNoGap) { EXPECT_TRUE(FindIn({WallBehind(), BoxBetween(-0.5, 0.5)}).empty()); }

TEST(FindGaps, ThingsFarApartHaveNoGap) { EXPECT_TRUE(FindIn(BoxesApart(0.4)).empty()); }

TEST(FindGaps, ThingsOfUnlikeClassesNeedNoGap) {
  EXPECT_TRUE(
      FindIn({WallBehind(), BoxBetween(-0.5, -0.05), BoxBetween(0.05, 0.5, kPersonClass)}).empty());
}

TEST(FindGaps, InstancesNeedNoGap) {
  Frame frame = RenderScene(BoxesApart(0.1), {});
  frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      frame.instances.At(u, v) = frame.labels.At(u, v) == kGoodsClass ? 1 : 0;
    }
  }
  EXPECT_TRUE(FindIn(frame).empty());
}

TEST(FindGaps, WhatIsAboveAGapStandsOnSomething) {
  EXPECT_TRUE(FindIn({WallBehind(),
                      Body(kGoodsClass, {kFrontM, -0.5, -0.5}, {kFrontM + 0.4, 0.5, -0.05}),
                      Body(kGoodsClass, {kFrontM, -0.5, 0.05}, {kFrontM + 0.4, 0.5, 0.5})})
                  .empty());
}

TEST(FindGaps, AGrooveIsNoGap) {
  Scene scene = BoxesApart(0.1);
  scene.push_back(Body(kGoodsClass, {kFrontM + 0.06, -0.4, -1.5}, {kFrontM + 0.2, 0.4, 1.5}));
  EXPECT_TRUE(FindIn(scene).empty());
}

TEST(FindGaps, AWrongDepthIsNoGap) {
  Frame frame = RenderScene({WallBehind(), BoxBetween(-0.5, 0.5)}, {});
  const int column = frame.camera.width_px / 2;
  const int row = frame.camera.height_px / 2;
  const std::uint16_t behind = frame.depth.units.At(column, row) * 2;
  // Two rows of cells.
  for (int v = row; v < row + 4; ++v) {
    for (int u = column; u < column + 20; ++u) frame.depth.units.At(u, v) = behind;
  }
  EXPECT_TRUE(FindIn(frame).empty());
}

}  // namespace
}  // namespace steadymap
