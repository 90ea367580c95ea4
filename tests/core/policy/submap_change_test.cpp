// Small scenes with known ground truth, processed by the submap_change policy.

#include "core/policy/submap_change.h"

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
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Scene;

MapStory SubmapStory() { return MapStory(ConfigOf(UpdatePolicy::kSubmapChange)); }

TEST(SubmapChange, KeepsASubmapAfterFiveDetections) {
  const Scene scene = {FarWall(), Goods(0.0)};
  MapStory story = SubmapStory();
  story.Look(scene, 4);
  EXPECT_TRUE(story.events().empty());
  EXPECT_TRUE(story.Present(kGoodsClass).empty());
  story.Look(scene, 1);
  const std::vector<ObjectEvent> created = story.EventsOf(EventType::kCreated, kGoodsClass);
  ASSERT_EQ(created.size(), 1U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_EQ(story.Present(kGoodsClass)[0]->id, created[0].object);
  EXPECT_EQ(story.Present(kGoodsClass)[0]->supporting_frames, 5U);
}

TEST(SubmapChange, ForgetsASubmapThatWasDetectedTooSeldom) {
  MapStory story = SubmapStory();
  story.Look({FarWall()}, 6);
  story.Look({FarWall(), Goods(0.0)}, 4);
  story.Look({FarWall()}, 5);
  EXPECT_TRUE(story.EventsOf(EventType::kCreated, kGoodsClass).empty());
  for (const auto& [id, object] : story.map().objects) {
    EXPECT_EQ(object->class_id, ClassId(kWallClass));
  }
}

TEST(SubmapChange, ReportsNoChangeOfASceneThatStaysTheSame) {
  const Scene scene = {FarWall(), Goods(-0.5), Goods(0.4)};
  MapStory story = SubmapStory();
  for (int visit = 0; visit < 3; ++visit) {
    story.Look(scene, 20, visit);
    // The pause is long enough to make all submaps inactive.
    story.Look({}, 6, visit);
  }
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 2U);
  EXPECT_EQ(story.Present(kGoodsClass).size(), 2U);
  for (const ObjectEvent& event : story.events()) EXPECT_EQ(event.type, EventType::kCreated);
}

TEST(SubmapChange, RemovesABoxThatDisappeared) {
  MapStory story = SubmapStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  story.Look({FarWall()}, 10);
  const std::vector<ObjectEvent> removed = story.EventsOf(EventType::kRemoved, kGoodsClass);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].reason, EventReason::kSeenThrough);
  EXPECT_TRUE(story.Present(kGoodsClass).empty());
  EXPECT_EQ(story.Present(kWallClass).size(), 1U) << "the wall behind stays";
  EXPECT_EQ(CountSurfaceIn(story.map(), Around(Goods(0.0), 0.1)), 0U);
}

TEST(SubmapChange, FindsAShiftedBoxAtItsNewPlaceOnly) {
  MapStory story = SubmapStory();
  story.Look({FarWall(), Goods(-0.35)}, 20);
  story.Look({FarWall(), Goods(0.35)}, 20, /*visit=*/1);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass, Revision(20)).size(), 1U);
  EXPECT_EQ(story.EventsOf(EventType::kRemoved, kGoodsClass, Revision(20)).size(), 1U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_NEAR(story.Present(kGoodsClass)[0]->cuboid.center_world.y(), 0.35, 0.06);
}

TEST(SubmapChange, BringsBackABoxThatStandsAgainWhereItStood) {
  MapStory story = SubmapStory();
  story.Look({FarWall(), Goods(0.0)}, 20);
  const ObjectId box = story.Present(kGoodsClass).at(0)->id;
  story.Look({FarWall()}, 15, /*visit=*/1);
  EXPECT_TRUE(story.Present(kGoodsClass).empty());
  story.Look({FarWall(), Goods(0.0)}, 15, /*visit=*/2);
  const std::vector<ObjectEvent> returned = story.EventsOf(EventType::kReturned, kGoodsClass);
  ASSERT_EQ(returned.size(), 1U);
  EXPECT_EQ(returned[0].object, box);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_EQ(story.Present(kGoodsClass)[0]->id, box);
}

}  // namespace
}  // namespace steadymap
