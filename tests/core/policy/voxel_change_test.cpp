// Small scenes with known ground truth, processed by the voxel_change policy.

#include "core/policy/voxel_change.h"

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Around;
using ::steadymap::testing::Body;
using ::steadymap::testing::ConfigOf;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneBody;

MapStory VoxelChangeStory() { return MapStory(ConfigOf(UpdatePolicy::kVoxelChange)); }

/// Returns the reasons of all events in a box.
std::vector<EventReason> ReasonsIn(const MapStory& story, const Box& box_world) {
  std::vector<EventReason> reasons;
  for (const ObjectEvent& event : story.events()) {
    EXPECT_EQ(event.type, EventType::kUpdated);
    EXPECT_EQ(event.object, kBackgroundId);
    if (box_world.contains(event.center_world)) reasons.push_back(event.reason);
  }
  return reasons;
}

TEST(VoxelChange, ReportsNothingOfASceneThatStaysTheSame) {
  const Scene scene = {FarWall(), Goods(-0.5), Goods(0.4)};
  MapStory story = VoxelChangeStory();
  for (int visit = 0; visit < 3; ++visit) story.Look(scene, 20, visit);
  EXPECT_TRUE(story.events().empty());
  EXPECT_GT(CountSurfaceIn(story.map(), Around(Goods(0.4), 0.05)), 100U);
}

TEST(VoxelChange, RemovesABoxThatDisappeared) {
  MapStory story = VoxelChangeStory();
  story.Look({FarWall(), Goods(0.0)}, 30);
  const std::size_t wall = CountSurfaceIn(story.map(), Around(FarWall(), 0.1));
  story.Look({FarWall()}, 15, /*visit=*/1);
  EXPECT_EQ(CountSurfaceIn(story.map(), Around(Goods(0.0), 0.15)), 0U);
  EXPECT_GE(CountSurfaceIn(story.map(), Around(FarWall(), 0.1)), wall);
  const std::vector<EventReason> reasons = ReasonsIn(story, Around(Goods(0.0), 0.1));
  ASSERT_FALSE(reasons.empty());
  for (const EventReason reason : reasons) EXPECT_EQ(reason, EventReason::kSeenThrough);
}

TEST(VoxelChange, AddsABoxWhereNothingWasKnown) {
  MapStory story = VoxelChangeStory();
  story.Look({FarWall()}, 20);
  story.Look({FarWall(), Goods(0.0)}, 10, /*visit=*/1);
  EXPECT_GT(CountSurfaceIn(story.map(), Around(Goods(0.0), 0.05)), 100U);
}

TEST(VoxelChange, ReplacesSurfaceByWhatWasPutBeforeIt) {
  const SceneBody panel = Body(kGoodsClass, {2.5, -0.4, -0.4}, {2.7, 0.4, 0.4});
  MapStory story = VoxelChangeStory();
  story.Look({FarWall()}, 20);
  story.Look({FarWall(), panel}, 15, /*visit=*/1);
  const std::vector<EventReason> reasons = ReasonsIn(story, Around(panel, 0.1));
  ASSERT_FALSE(reasons.empty());
  EXPECT_EQ(reasons.front(), EventReason::kNewSurface);
  const Box at_panel(Eigen::Vector3d(2.46, -0.3, -0.3), Eigen::Vector3d(2.54, 0.3, 0.3));
  const Box at_wall(Eigen::Vector3d(2.56, -0.3, -0.3), Eigen::Vector3d(2.64, 0.3, 0.3));
  EXPECT_GT(CountSurfaceIn(story.map(), at_panel), 100U);
  EXPECT_EQ(CountSurfaceIn(story.map(), at_wall), 0U);
}

TEST(VoxelChange, FindsAShiftedBoxAtItsNewPlaceOnly) {
  MapStory story = VoxelChangeStory();
  story.Look({FarWall(), Goods(-0.4)}, 30);
  story.Look({FarWall(), Goods(0.4)}, 20, /*visit=*/1);
  EXPECT_EQ(CountSurfaceIn(story.map(), Around(Goods(-0.4), 0.04)), 0U);
  EXPECT_GT(CountSurfaceIn(story.map(), Around(Goods(0.4), 0.05)), 100U);
}

TEST(VoxelChange, ClearsByRaysThatEndOnAPerson) {
  const SceneBody person = Body(kPersonClass, {2.2, -0.6, -0.7}, {2.4, 0.6, 0.7});
  MapStory story = VoxelChangeStory();
  story.Look({FarWall(), Goods(0.0, 1.2)}, 30);
  story.Look({FarWall(), person}, 15, /*visit=*/1);
  const Box front(Eigen::Vector3d(1.15, -0.2, -0.2), Eigen::Vector3d(1.25, 0.2, 0.2));
  EXPECT_EQ(CountSurfaceIn(story.map(), front), 0U);
}

TEST(VoxelChange, FollowsAChangeWithinOneVisitByItsMean) {
  MapStory story = VoxelChangeStory();
  story.Look({FarWall(), Goods(0.0)}, 10);
  story.Look({FarWall()}, 60);
  EXPECT_EQ(CountSurfaceIn(story.map(), Around(Goods(0.0), 0.1)), 0U);
}

TEST(VoxelChange, ForgetsTheFreshLayerWhenAVisitEnds) {
  MapStory story = VoxelChangeStory();
  story.Look({FarWall()}, 12);
  EXPECT_FALSE(story.map().objects.empty());
  for (const auto& [id, tile] : story.map().objects) {
    EXPECT_EQ(tile->status, ObjectStatus::kTentative);
  }
  const ObjectId last = story.map().newest_object;
  story.Look({FarWall()}, 1, /*visit=*/1);
  for (const auto& [id, tile] : story.map().objects) EXPECT_GT(id, last);
}

}  // namespace
}  // namespace steadymap
