// A wall at 2 m that frames find, miss, or do not see.

#include "core/change/surface_looks.h"

#include <memory>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kScale;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;
using ::steadymap::testing::StateOf;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::WallVolume;

// The left half of the view is closed, so that a frame shows the right half of the wall at most.
Scene BesideAClosedHalf(const testing::SceneBody& beside) {
  return {Body(kGoodsClass, {1.0, 0.0, -4.0}, {1.1, 4.0, 4.0}), beside};
}

class SurfaceLooksTest : public ::testing::Test {
 protected:
  SurfaceLooksTest() : wall_(ObjectId(1), Eigen::Vector3d::Zero(), kScale), cloud_(MapConfig()) {
    StoreVolume(WallVolume(2.0, kScale), &wall_);
    StateOf(&wall_).class_id = ClassId(kWallClass);
  }

  /// Looks at a wall that fills the image. Returns true if it was a look at the known wall.
  bool Look(double depth_m, double time_s, std::uint16_t label = kWallClass) {
    return Look(RenderScene({Body(label, {depth_m, -4.0, -4.0}, {depth_m + 0.3, 4.0, 4.0})}, {}),
                time_s);
  }

  bool Look(const Frame& frame, double time_s) {
    cloud_.Compute(frame);
    samples_.Compute(cloud_);
    tiles_.Compute(frame.depth);
    return AddLook({cloud_, samples_, tiles_},
                   parameters_,
                   kScale,
                   Timestamp::FromSeconds(time_s),
                   wall_,
                   &StateOf(&wall_).evidence);
  }

  /// Finds the whole wall in several frames. Returns the number of its evidence cells.
  std::size_t FindAll() {
    for (int i = 0; i < 5; ++i) Look(2.0, i);
    return CountLooks(wall_).found;
  }

  /// Sees through the right half of the wall as often as changes all scores.
  void SeeThroughRightHalf() {
    const Frame frame =
        RenderScene(BesideAClosedHalf(Body(kWallClass, {3.0, -4.0, -4.0}, {3.1, 4.0, 4.0})), {});
    for (int i = 0; i <= parameters_.confirming_looks; ++i) Look(frame, 100.0 + i);
  }

  LookParameters parameters_;
  TrackedObject wall_;
  SemanticCloud cloud_;
  SampleGrid samples_;
  MinDepthGrid tiles_;
};

TEST_F(SurfaceLooksTest, SurfaceInItsPlaceIsFound) {
  ASSERT_TRUE(Look(2.0, 1.0));
  EXPECT_GT(CountLooks(wall_).found, 50U);
  EXPECT_EQ(CountLooks(wall_).gone, 0U);
}

TEST_F(SurfaceLooksTest, ASurfaceAtARightAngleIsAnotherOne) {
  // The side of a long box crosses the plane of the wall; on the left, the view is closed before.
  const Frame frame = RenderScene({Body(kWallClass, {1.2, -4.0, -4.0}, {4.0, -0.2, 4.0}),
                                   Body(kWallClass, {1.0, 0.2, -4.0}, {1.1, 4.0, 4.0}),
                                   Body(kWallClass, {2.3, -4.0, -4.0}, {2.4, 4.0, 4.0})},
                                  {.eye_world = {0.0, 0.1, 0.0}, .target_world = {2.0, -0.2, 0.0}});
  Look(frame, 1.0);
  EXPECT_EQ(CountLooks(wall_).found, 0U);
}

TEST_F(SurfaceLooksTest, SurfaceThatIsSeenThroughIsGone) {
  ASSERT_TRUE(Look(3.0, 1.0));
  EXPECT_EQ(CountLooks(wall_).found, 0U);
  EXPECT_GT(CountLooks(wall_).gone, 50U);
}

TEST_F(SurfaceLooksTest, OccludedSurfaceIsNotLookedAt) {
  EXPECT_FALSE(Look(1.0, 1.0));
  EXPECT_EQ(CountLooks(wall_).looked_at(), 0U);
}

TEST_F(SurfaceLooksTest, SurfaceOfAnotherClassTookItsPlace) {
  ASSERT_TRUE(Look(2.0, 1.0, kGoodsClass));
  EXPECT_EQ(CountLooks(wall_).found, 0U);
  EXPECT_GT(CountLooks(wall_).gone, 50U);
}

TEST_F(SurfaceLooksTest, WithoutLabelsTheSurfaceDecides) {
  parameters_.labels_decide = false;
  ASSERT_TRUE(Look(2.0, 1.0, kGoodsClass));
  EXPECT_EQ(CountLooks(wall_).gone, 0U);
}

TEST_F(SurfaceLooksTest, LooksOfOneMomentCountOnce) {
  ASSERT_TRUE(Look(2.0, 1.0));
  const ObjectEvidence once = wall_.state().evidence;
  EXPECT_FALSE(Look(2.0, 1.0 + 0.5 * parameters_.min_interval_s));
  EXPECT_EQ(wall_.state().evidence, once);
}

TEST_F(SurfaceLooksTest, WhatIsShownOfAThingThatIsGoneTellsOfTheRest) {
  StateOf(&wall_).status = ObjectStatus::kTentative;
  const std::size_t found = FindAll();
  SeeThroughRightHalf();
  EXPECT_EQ(CountLooks(wall_).found, 0U);
  EXPECT_GT(CountLooks(wall_).gone, 20U);
  EXPECT_LT(CountLooks(wall_).gone, found);
}

TEST_F(SurfaceLooksTest, APartThatIsGoneTellsNothingOfWhatIsNotShown) {
  StateOf(&wall_).status = ObjectStatus::kTentative;
  const std::size_t found = FindAll();
  // Above eye level, the shown half is gone.
  Scene bodies = BesideAClosedHalf(Body(kWallClass, {2.0, -4.0, -4.0}, {2.3, 4.0, 0.0}));
  bodies.push_back(Body(kWallClass, {3.0, -4.0, -4.0}, {3.1, 4.0, 4.0}));
  const Frame frame = RenderScene(bodies, {});
  for (int i = 0; i <= parameters_.confirming_looks; ++i) Look(frame, 100.0 + i);
  EXPECT_GT(CountLooks(wall_).gone, 10U);
  EXPECT_EQ(CountLooks(wall_).looked_at(), found);
}

TEST_F(SurfaceLooksTest, AKnownThingThatLeavesInViewLeavesAsAWhole) {
  StateOf(&wall_).status = ObjectStatus::kPresent;
  FindAll();
  SeeThroughRightHalf();
  EXPECT_EQ(CountLooks(wall_).found, 0U);
  EXPECT_GT(CountLooks(wall_).gone, 20U);
}

TEST_F(SurfaceLooksTest, WhatASessionFindsGoneOfAKnownThingTellsNothingOfTheRest) {
  // The poses of two sessions differ, or the thing has lost a part in between.
  StateOf(&wall_).status = ObjectStatus::kPresent;
  const Frame left_half = RenderScene({Body(kGoodsClass, {1.0, -4.0, -4.0}, {1.1, 0.0, 4.0}),
                                       Body(kWallClass, {2.0, -4.0, -4.0}, {2.3, 4.0, 4.0})},
                                      {});
  for (int i = 0; i < 5; ++i) Look(left_half, i);
  const std::size_t found = CountLooks(wall_).found;
  ASSERT_GT(found, 20U);
  SeeThroughRightHalf();
  EXPECT_GT(CountLooks(wall_).gone, 20U);
  EXPECT_GE(CountLooks(wall_).found, found - 3U);
}

TEST_F(SurfaceLooksTest, CountsWhatWasLookedAtAfterATime) {
  Look(2.0, 1.0);
  EXPECT_EQ(CountLooks(wall_, Timestamp::FromSeconds(1.0)).looked_at(), 0U);
  EXPECT_GT(CountLooks(wall_, Timestamp::FromSeconds(0.9)).found, 50U);
}

TEST(LookCount, HalfOfTheCellsOfASmallObjectTellOfIt) {
  EXPECT_EQ(LookCount{.cells = 100}.DecidingCells(3), 3U);
  EXPECT_EQ(LookCount{.cells = 6}.DecidingCells(3), 3U);
  EXPECT_EQ(LookCount{.cells = 5}.DecidingCells(3), 2U) << "a camera sees no more than half";
  EXPECT_EQ(LookCount{.cells = 4}.DecidingCells(3), 2U);
  EXPECT_EQ(LookCount{.cells = 1}.DecidingCells(3), 1U);
  EXPECT_EQ(LookCount{.cells = 0}.DecidingCells(3), 1U) << "no cells tell nothing";
}

TEST_F(SurfaceLooksTest, AFewLooksOutweighAnyNumberOfOlderOnes) {
  for (int i = 0; i < 50; ++i) Look(2.0, i);
  for (int i = 0; i <= parameters_.confirming_looks; ++i) Look(3.0, 100.0 + i);
  EXPECT_EQ(CountLooks(wall_).found, 0U);
  EXPECT_GT(CountLooks(wall_).gone, 50U);
}

}  // namespace
}  // namespace steadymap
