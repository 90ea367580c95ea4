// Small scenes with known ground truth, processed by the tracking policy.

#include "core/policy/tracking.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Around;
using ::steadymap::testing::ConfigOf;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;

/// Returns frames from frame `first` on that show three sides of the goods, since a single side
/// does not constrain motion along itself.
std::vector<Frame> LookAtCorner(const Scene& scene, int first, int count) {
  std::vector<Frame> frames;
  for (int i = first; i < first + count; ++i) {
    frames.push_back(RenderScene(scene,
                                 {.eye_world = {0.3, -1.1 + 0.1 * std::sin(0.7 * i), 1.2},
                                  .target_world = {1.7, 0.0, 0.0},
                                  .capture_time_s = 100.0 + 0.1 * i}));
  }
  return frames;
}

MapStory TrackingStory() { return MapStory(ConfigOf(UpdatePolicy::kTracking)); }

TEST(Tracking, ReportsNoChangeOfASceneThatStaysTheSame) {
  MapStory story = TrackingStory();
  story.Look({FarWall(), Goods(-0.5), Goods(0.4)}, 40);
  EXPECT_EQ(story.Present(kGoodsClass).size(), 2U);
  EXPECT_EQ(story.events().size(), 3U);
  for (const ObjectEvent& event : story.events()) EXPECT_EQ(event.type, EventType::kCreated);
}

TEST(Tracking, FollowsABoxThatIsCarriedADecimetreAFrame) {
  MapStory story = TrackingStory();
  double y = -0.5;
  story.Play(LookAtCorner({FarWall(), Goods(y)}, 0, 10));
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const ObjectId box = story.Present(kGoodsClass)[0]->id;
  const Eigen::Vector3d start_world = story.Present(kGoodsClass)[0]->T_world_object.position_world;
  for (int step = 1; step <= 8; ++step) {
    y += 0.1;
    story.Play(LookAtCorner({FarWall(), Goods(y)}, 9 + step, 1));
    ASSERT_EQ(story.Present(kGoodsClass).size(), 1U) << step;
    const MapObject& object = *story.Present(kGoodsClass)[0];
    EXPECT_EQ(object.id, box);
    // A rotation moves the origin of the object frame, but not the box centre.
    const Eigen::Vector3d middle_object = Eigen::Vector3d(1.8, -0.5, 0.0) - start_world;
    const Eigen::Vector3d middle_world = object.T_world_object.ToIsometry() * middle_object;
    EXPECT_LT((middle_world - Eigen::Vector3d(1.8, y, 0.0)).norm(), 0.02) << step;
    EXPECT_NEAR(object.T_world_object.yaw_rad, 0.0, 0.035);
  }
  const std::vector<ObjectEvent> moved = story.EventsOf(EventType::kMoved, kGoodsClass);
  ASSERT_GE(moved.size(), 4U);
  for (const ObjectEvent& event : moved) {
    EXPECT_EQ(event.object, box);
    ASSERT_TRUE(event.old_center_world.has_value());
    EXPECT_GT(event.center_world.y(), event.old_center_world->y() + 0.08);
  }
}

TEST(Tracking, TellsASlowMoveOnceItHasComeFar) {
  MapStory story = TrackingStory();
  story.Play(LookAtCorner({FarWall(), Goods(-0.2)}, 0, 10));
  for (int step = 1; step <= 9; ++step) {
    story.Play(LookAtCorner({FarWall(), Goods(-0.2 + 0.03 * step)}, 9 + step, 1));
  }
  const std::vector<ObjectEvent> moved = story.EventsOf(EventType::kMoved, kGoodsClass);
  ASSERT_EQ(moved.size(), 2U);
  EXPECT_NEAR((moved[0].center_world - *moved[0].old_center_world).norm(), 0.12, 0.03);
}

TEST(Tracking, DropsABoxThatJumpsAndTakesItForAnother) {
  MapStory story = TrackingStory();
  story.Play(LookAtCorner({FarWall(), Goods(0.0)}, 0, 12));
  const ObjectId box = story.Present(kGoodsClass).at(0)->id;
  story.Play(LookAtCorner({FarWall(), Goods(0.3)}, 12, 8));
  const std::vector<ObjectEvent> removed = story.EventsOf(EventType::kRemoved, kGoodsClass);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].object, box);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_NE(story.Present(kGoodsClass)[0]->id, box);
}

TEST(Tracking, KeepsWhatIsSimplyGone) {
  // A known failure of this policy, which the other policies avoid.
  MapStory story = TrackingStory();
  story.Look({FarWall(), Goods(0.0)}, 12);
  story.Look({FarWall()}, 40);
  EXPECT_TRUE(story.EventsOf(EventType::kRemoved, kGoodsClass).empty());
  EXPECT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_GT(CountSurfaceIn(story.map(), Around(Goods(0.0), 0.05)), 100U);
}

}  // namespace
}  // namespace steadymap
