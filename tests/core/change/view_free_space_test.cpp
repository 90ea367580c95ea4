#include "core/change/view_free_space.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneLook;

/// One frame and its observed free space, up to 2.5 m.
struct Sight {
  explicit Sight(const Scene& scene, const SceneLook& look = {})
      : frame(RenderScene(scene, look)), cloud(MapConfig()) {
    cloud.Compute(frame);
    tiles.Compute(frame.depth);
  }

  ViewFreeSpace View() const { return {cloud, tiles, 2.5}; }

  Frame frame;
  SemanticCloud cloud;
  MinDepthGrid tiles;
};

Scene WallAt(double x) { return {Body(4, {x, -5.0, -5.0}, {x + 0.5, 5.0, 5.0})}; }

TEST(ViewFreeSpace, LooksThroughWhatLiesBeforeASurfaceOnly) {
  const Sight sight(WallAt(2.0));
  const ViewFreeSpace view = sight.View();
  EXPECT_TRUE(view.LooksThrough({1.0F, 0.0F, 0.0F}, 0.1F));
  EXPECT_TRUE(view.LooksThrough({1.85F, 0.2F, 0.1F}, 0.1F));
  EXPECT_FALSE(view.LooksThrough({1.95F, 0.2F, 0.1F}, 0.1F)) << "within the margin";
  EXPECT_FALSE(view.LooksThrough({2.3F, 0.0F, 0.0F}, 0.1F)) << "behind";
  EXPECT_FALSE(view.LooksThrough({-1.0F, 0.0F, 0.0F}, 0.1F)) << "behind the camera";
  EXPECT_FALSE(view.LooksThrough({1.0F, 3.0F, 0.0F}, 0.1F)) << "out of view";
}

TEST(ViewFreeSpace, LooksNoFurtherThanDepthIsTrusted) {
  const Sight sight(WallAt(3.0));
  EXPECT_TRUE(sight.View().LooksThrough({2.4F, 0.0F, 0.0F}, 0.1F));
  EXPECT_FALSE(sight.View().LooksThrough({2.6F, 0.0F, 0.0F}, 0.1F));
}

TEST(ViewFreeSpace, LooksThroughNothingWithoutReturns) {
  const Sight sight(Scene{});
  EXPECT_FALSE(sight.View().LooksThrough({1.0F, 0.0F, 0.0F}, 0.1F));
  EXPECT_FALSE(sight.View().IsClear({1.0F, 0.0F, 0.0F}, 0.1F));
  EXPECT_TRUE(sight.View().EndOfRay(10, 10).isApprox(sight.View().camera_world()));
}

TEST(ViewFreeSpace, TakesNoPointJustAboveTheGroundForClear) {
  // The camera is low: the ray through a point 10 cm above the ground continues for 75 cm.
  const Scene ground = {Body(1, {-5.0, -5.0, -1.0}, {9.0, 5.0, -0.3})};
  const Sight sight(ground, {.target_world = {2.0, 0.0, -0.3}});
  const Eigen::Vector3f low(1.5F, 0.0F, -0.2F);
  EXPECT_TRUE(sight.View().LooksThrough(low, 0.15F));
  EXPECT_FALSE(sight.View().IsClear(low, 0.15F));
  EXPECT_TRUE(sight.View().IsClear({0.8F, 0.0F, -0.1F}, 0.15F));
}

TEST(ViewFreeSpace, EndsRaysAtTheSurface) {
  const Sight sight(WallAt(2.0));
  const ViewFreeSpace view = sight.View();
  const Eigen::Vector3f end_world = view.EndOfRay(view.columns() / 2, view.rows() / 4);
  EXPECT_NEAR(end_world.x(), 2.0F, 0.01F);
  EXPECT_GT(end_world.z(), 0.1F);
}

}  // namespace
}  // namespace steadymap
