// Small scenes with known ground truth, processed by the pocd policy: objects in front of a wall,
// observed from several poses.

#include "core/policy/object_mapper.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "core/mapper.h"
#include "tests/core/policy/map_story.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Around;
using ::steadymap::testing::Body;
using ::steadymap::testing::CountSurfaceIn;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::FarWall;
using ::steadymap::testing::Goods;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::LookAtScene;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneBody;
using ::steadymap::testing::SmallFrame;

constexpr std::uint16_t kRackClass = 6;

/// Returns the number of observed voxels of a volume within a box in the world frame.
std::size_t CountVoxelsIn(const VoxelReader& volume,
                          const Eigen::Vector3d& position_world,
                          double voxel_size_m,
                          const Box& box_world) {
  std::size_t count = 0;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      const Eigen::Vector3i voxel(origin.x + static_cast<int>(offset >> 6),
                                  origin.y + static_cast<int>((offset >> 3) & 7),
                                  origin.z + static_cast<int>(offset & 7));
      const Eigen::Vector3d center_world = position_world + voxel.cast<double>() * voxel_size_m;
      if (IsSet(leaf.observed, offset) && box_world.contains(center_world)) ++count;
    }
  });
  return count;
}

/// Returns the number of observed background voxels within a box in the world frame.
std::size_t CountBackgroundIn(const MapSnapshot& map, const Box& box_world) {
  return CountVoxelsIn(map.background, Eigen::Vector3d::Zero(), map.scale.voxel_size_m, box_world);
}

/// Returns the number of observed voxels of present objects and the background within a box in the
/// world frame.
std::size_t CountVoxelsIn(const MapSnapshot& map, const Box& box_world) {
  std::size_t count = CountBackgroundIn(map, box_world);
  for (const auto& [id, object] : map.objects) {
    if (object->status != ObjectStatus::kPresent) continue;
    count += CountVoxelsIn(
        *object->volume, object->T_world_object.position_world, map.scale.voxel_size_m, box_world);
  }
  return count;
}

TEST(ObjectMapper, CreatesABoxAfterTheConfirmingViews) {
  const Scene scene = {FarWall(), Goods(0.0)};
  MapStory story(PocdConfig());
  story.Look(scene, 3);
  EXPECT_TRUE(story.events().empty());
  EXPECT_TRUE(story.Present(kGoodsClass).empty());
  story.Look(scene, 20);
  const std::vector<ObjectEvent> created = story.EventsOf(EventType::kCreated, kGoodsClass);
  ASSERT_EQ(created.size(), 1U);
  EXPECT_EQ(created[0].revision, Revision(4));
  EXPECT_EQ(created[0].reason, EventReason::kNewSurface);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kWallClass).size(), 1U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject& box = *story.Present(kGoodsClass)[0];
  EXPECT_EQ(box.id, created[0].object);
  EXPECT_NEAR(box.cuboid.center_world.y(), 0.0, 0.06);
  EXPECT_NEAR(box.cuboid.size_m.z(), 0.6, 0.11);
  EXPECT_GT(box.belief.stationarity(), 0.67);
}

TEST(ObjectMapper, KnowsAPostOfWhichNoFrameShowsMuch) {
  // Only 0.05 square metres of the post face the camera: it becomes an object only after more
  // frames.
  const Scene scene = {FarWall(), Body(kRackClass, {1.6, -0.03, -0.5}, {1.66, 0.03, 0.3})};
  MapStory story(PocdConfig());
  story.Look(scene, 4);
  EXPECT_TRUE(story.Present(kRackClass).empty());
  story.Look(scene, 20);
  ASSERT_EQ(story.EventsOf(EventType::kCreated, kRackClass).size(), 1U);
  ASSERT_EQ(story.Present(kRackClass).size(), 1U);
  EXPECT_NEAR(story.Present(kRackClass)[0]->cuboid.size_m.z(), 0.8, 0.11);
}

TEST(ObjectMapper, KnowsSmallThingsInAFineMapAlone) {
  const Scene scene = {FarWall(), Body(kGoodsClass, {1.3, -0.06, -0.06}, {1.42, 0.06, 0.06})};
  MapStory coarse(PocdConfig());
  coarse.Look(scene, 10);
  EXPECT_EQ(coarse.Present(kGoodsClass).size(), 0U);
  MapConfig config = PocdConfig();
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.06;
  MapStory fine(config);
  fine.Look(scene, 10);
  EXPECT_EQ(fine.Present(kGoodsClass).size(), 1U);
}

TEST(ObjectMapper, KnowsAPanelAgainByTheLittleThatShowsOfIt) {
  const SceneBody panel = Body(kWallClass, {2.0, -0.6, -0.6}, {2.1, 0.6, 0.6});
  const SceneBody goods = Body(kGoodsClass, {1.5, -0.9, -1.5}, {1.9, 0.9, 0.40});
  MapStory story(PocdConfig());
  story.Look({panel}, 30);
  ASSERT_EQ(story.Present(kWallClass).size(), 1U);
  const ObjectId id = story.Present(kWallClass)[0]->id;
  story.Look({FarWall()}, 60, 1);
  ASSERT_EQ(story.EventsOf(EventType::kRemoved, kWallClass).size(), 1U);
  story.Look({FarWall(), goods, panel}, 30, 2);
  const std::vector<ObjectEvent> returned = story.EventsOf(EventType::kReturned, kWallClass);
  ASSERT_EQ(returned.size(), 1U);
  EXPECT_EQ(returned[0].object, id);
}

TEST(ObjectMapper, ReportsNoChangeOfASceneThatStaysTheSame) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(-0.5), Goods(0.4)}, 60);
  EXPECT_EQ(story.Present(kGoodsClass).size(), 2U);
  for (const ObjectEvent& event : story.events()) {
    EXPECT_EQ(event.type, EventType::kCreated) << NameOf(event.type);
  }
}

TEST(ObjectMapper, RemovesABoxThatDisappeared) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(0.0)}, 30);
  const Box place = Around(Goods(0.0), 0.1);
  EXPECT_GT(CountVoxelsIn(story.map(), place), 200U);
  story.Look({FarWall()}, 15);
  const std::vector<ObjectEvent> removed = story.EventsOf(EventType::kRemoved, kGoodsClass);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].reason, EventReason::kSeenThrough);
  EXPECT_GT(removed[0].revision, Revision(30));
  EXPECT_TRUE(story.Present(kGoodsClass).empty());
  EXPECT_EQ(CountVoxelsIn(story.map(), place), 0U);
  EXPECT_EQ(story.Present(kWallClass).size(), 1U) << "the wall behind stays";
}

TEST(ObjectMapper, KnowsABoxThatComesBack) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(0.0)}, 45);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject first = *story.Present(kGoodsClass)[0];
  story.Look({FarWall()}, 45);
  ASSERT_EQ(story.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  story.Look({FarWall(), Goods(0.0)}, 15);
  const std::vector<ObjectEvent> returned = story.EventsOf(EventType::kReturned, kGoodsClass);
  ASSERT_EQ(returned.size(), 1U);
  EXPECT_EQ(returned[0].object, first.id);
  EXPECT_EQ(returned[0].reason, EventReason::kShapeMatched);
  EXPECT_LT(returned[0].before.stationarity(), 0.4);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject& again = *story.Present(kGoodsClass)[0];
  EXPECT_EQ(again.id, first.id);
  EXPECT_EQ(again.first_seen, first.first_seen);
  EXPECT_EQ(again.in_place_since, returned[0].time);
}

TEST(ObjectMapper, TakesABoxBesideAnOldPlaceAsNew) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(-0.1)}, 45);
  story.Look({FarWall()}, 45);
  ASSERT_EQ(story.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  story.Look({FarWall(), Goods(0.15)}, 15);
  EXPECT_TRUE(story.EventsOf(EventType::kReturned, kGoodsClass).empty());
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 2U);
}

TEST(ObjectMapper, KnowsABoxThatWasMovedAside) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(-0.3)}, 45);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const ObjectId box = story.Present(kGoodsClass)[0]->id;
  story.Look({FarWall(), Goods(0.3)}, 25);
  const std::vector<ObjectEvent> moved = story.EventsOf(EventType::kMoved, kGoodsClass);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].object, box);
  ASSERT_TRUE(moved[0].old_center_world.has_value());
  EXPECT_NEAR(moved[0].old_center_world->y(), -0.3, 0.1);
  EXPECT_NEAR(moved[0].center_world.y(), 0.3, 0.1);
  EXPECT_GT(moved[0].confidence.value_or(0.0), 0.5);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_EQ(story.Present(kGoodsClass)[0]->id, box);
  EXPECT_NEAR(story.Present(kGoodsClass)[0]->cuboid.center_world.y(), 0.3, 0.1);
  EXPECT_FALSE(story.map().objects.contains(moved[0].related)) << "one thing is one object";
  for (const ObjectEvent& event : story.events()) {
    EXPECT_FALSE(event.type == EventType::kRemoved && event.revision > moved[0].revision);
  }
}

/// Returns frames of a body that appears rotated in place by `yaw_rad`: the reported camera poses
/// are rotated about the centre of the body.
std::vector<Frame> LookAtTurned(const SceneBody& body, double yaw_rad, int first, int count) {
  const Eigen::Vector3d center_world = body.box_world.center();
  const Eigen::Isometry3d turn = Eigen::Translation3d(center_world) *
                                 Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                                 Eigen::Translation3d(-center_world);
  std::vector<Frame> frames = LookAtScene({body}, first, count);
  for (Frame& frame : frames) frame.T_world_camera = turn * frame.T_world_camera;
  return frames;
}

TEST(ObjectMapper, NoticesABoxThatWasTurned) {
  MapStory story(PocdConfig());
  story.Look({Goods(0.0)}, 45);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  // The yaw of a box is ambiguous modulo a quarter turn.
  const auto yaw_rad = [&] {
    return std::remainder(story.Present(kGoodsClass)[0]->cuboid.yaw_rad, M_PI / 2);
  };
  ASSERT_NEAR(yaw_rad(), 0.0, 0.05);
  story.Play(LookAtTurned(Goods(0.0), 0.22, 45, 45));
  const std::vector<ObjectEvent> removed = story.EventsOf(EventType::kRemoved, kGoodsClass);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].reason, EventReason::kDisplaced);
  EXPECT_EQ(story.EventsOf(EventType::kReturned, kGoodsClass).size(), 0U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  EXPECT_NEAR(yaw_rad(), 0.22, 0.05);
}

TEST(ObjectMapper, TakesALittleTurnForPoseError) {
  MapStory story(PocdConfig());
  story.Look({Goods(0.0)}, 45);
  story.Play(LookAtTurned(Goods(0.0), 0.02, 45, 45));
  EXPECT_EQ(story.events().size(), 1U);
}

TEST(ObjectMapper, KeepsWhatItKnewOfABoxThatMovedFarAway) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(-0.55)}, 45);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject before = *story.Present(kGoodsClass)[0];
  story.Look({FarWall()}, 25);
  ASSERT_EQ(story.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  story.Look({FarWall(), Goods(0.5)}, 20);
  const std::vector<ObjectEvent> moved = story.EventsOf(EventType::kMoved, kGoodsClass);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].reason, EventReason::kShapeMatched);
  EXPECT_EQ(moved[0].object, before.id);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject& after = *story.Present(kGoodsClass)[0];
  EXPECT_EQ(after.id, before.id);
  EXPECT_EQ(after.first_seen, before.first_seen);
  EXPECT_NEAR(after.cuboid.center_world.y(), 0.5, 0.1);
  // The left side was observed at the first position, the right side at the second.
  EXPECT_GE(after.volume->CountObservedVoxels(), before.volume->CountObservedVoxels());
}

TEST(ObjectMapper, NeverGuessesWhichOfTwoTwinsMoved) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(-0.8), Goods(0.0)}, 45);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 2U);
  story.Look({FarWall()}, 30);
  ASSERT_EQ(story.EventsOf(EventType::kRemoved, kGoodsClass).size(), 2U);
  story.Look({FarWall(), Goods(0.8)}, 20);
  EXPECT_TRUE(story.EventsOf(EventType::kMoved, kGoodsClass).empty());
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 3U);
}

/// Returns a pile with its top at `top_m`.
SceneBody Pile(double top_m) { return Body(kGoodsClass, {1.6, -0.4, -0.8}, {2.0, 0.4, top_m}); }

TEST(ObjectMapper, CutsOffThePartOfAPileThatWasTakenAway) {
  MapStory story(PocdConfig());
  story.Look({FarWall(), Pile(0.6)}, 30);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const ObjectId pile = story.Present(kGoodsClass)[0]->id;
  story.Look({FarWall(), Pile(0.2)}, 25);
  const std::vector<ObjectEvent> split = story.EventsOf(EventType::kSplit, kGoodsClass);
  ASSERT_EQ(split.size(), 1U);
  EXPECT_EQ(split[0].related, pile);
  const std::vector<ObjectEvent> removed = story.EventsOf(EventType::kRemoved, kGoodsClass);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed[0].object, split[0].object);
  EXPECT_GT(removed[0].center_world.z(), 0.2);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject& rest = *story.Present(kGoodsClass)[0];
  EXPECT_EQ(rest.id, pile);
  EXPECT_NEAR(rest.cuboid.highest_m(), 0.2, 0.15);
  EXPECT_EQ(story.map().objects.at(removed[0].object)->status, ObjectStatus::kArchived);
}

TEST(ObjectMapper, TellsWhatStayedOfAnObjectThatWentAsNoNewThing) {
  const SceneBody crate = Body(kGoodsClass, {1.6, 0.0, -0.4}, {2.0, 0.3, 0.0});
  MapStory story(PocdConfig());
  story.Look({FarWall(), Body(kGoodsClass, {1.6, -0.9, -0.4}, {2.0, 0.0, 0.5}), crate}, 30);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U) << "they touch";
  const ObjectId whole = story.Present(kGoodsClass)[0]->id;
  story.Look({FarWall(), crate}, 25);
  ASSERT_EQ(story.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  const std::vector<ObjectEvent> split = story.EventsOf(EventType::kSplit, kGoodsClass);
  ASSERT_EQ(split.size(), 1U);
  EXPECT_EQ(split[0].related, whole);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
  const MapObject& rest = *story.Present(kGoodsClass)[0];
  EXPECT_EQ(rest.id, split[0].object);
  EXPECT_EQ(rest.first_seen, story.map().objects.at(whole)->first_seen);
  EXPECT_NEAR(rest.cuboid.center_world.y(), 0.15, 0.1);
}

TEST(ObjectMapper, TakesAHandsBreadthBesideARackForAPartOfIt) {
  const SceneBody rack = Body(kRackClass, {1.6, -0.8, -0.8}, {2.0, 0.0, 0.8});
  const SceneBody board = Body(kRackClass, {1.6, 0.15, 0.0}, {1.8, 0.55, 0.15});
  MapStory story(PocdConfig());
  story.Look({FarWall(), rack}, 60);
  story.Look({FarWall(), rack, board}, 20);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kRackClass).size(), 1U);
  EXPECT_EQ(story.Present(kRackClass).size(), 1U);
  EXPECT_GT(CountVoxelsIn(story.map(), Around(board, 0.05)), 0U);
}

TEST(ObjectMapper, ForgetsPartsThatAreTooSmallToHaveBeenThings) {
  const SceneBody rack = Body(kRackClass, {1.6, -0.8, -0.8}, {2.0, 0.4, 0.4});
  // A layer of 12 cm on top of the rack, as from a sensor error, that is never observed again.
  const SceneBody crust = Body(kRackClass, {1.6, -0.8, 0.4}, {2.0, 0.4, 0.52});
  MapStory story(PocdConfig());
  story.Look({FarWall(), rack, crust}, 20);
  story.Look({FarWall(), rack}, 40);
  EXPECT_TRUE(story.EventsOf(EventType::kSplit, kRackClass).empty());
  EXPECT_TRUE(story.EventsOf(EventType::kRemoved, kRackClass).empty());
  ASSERT_EQ(story.Present(kRackClass).size(), 1U);
  EXPECT_LT(story.Present(kRackClass)[0]->cuboid.highest_m(), 0.5);
  for (const auto& [id, object] : story.map().objects) {
    EXPECT_NE(object->status, ObjectStatus::kArchived);
  }
  ExpectSameMap(story.told(), story.map());
}

TEST(ObjectMapper, CutsOffASliverThatWasMissedForLong) {
  const SceneBody rack = Body(kRackClass, {1.6, -0.8, -0.8}, {2.0, 0.4, 0.4});
  const SceneBody knob = Body(kRackClass, {1.6, -0.3, 0.4}, {1.7, -0.2, 0.55});
  const Box place(Eigen::Vector3d(1.5, -0.4, 0.46), Eigen::Vector3d(1.8, -0.1, 0.7));
  MapStory story(PocdConfig());
  story.Look({FarWall(), rack, knob}, 20);
  ASSERT_GT(CountSurfaceIn(story.map(), place), 0U);
  story.Look({FarWall(), rack}, 15);
  EXPECT_GT(CountSurfaceIn(story.map(), place), 0U) << "so little may be noise";
  story.Look({FarWall(), rack}, 15);
  EXPECT_EQ(CountSurfaceIn(story.map(), place), 0U);
  EXPECT_TRUE(story.EventsOf(EventType::kRemoved, kRackClass).empty());
  ExpectSameMap(story.told(), story.map());
}

TEST(ObjectMapper, GivesAnEdgeTooSmallToBeAThingToWhatItTouches) {
  const SceneBody rack = Body(kRackClass, {1.6, -0.8, -0.8}, {2.0, 0.0, 0.4});
  // A rod that protrudes by 12 cm into previously empty space.
  const SceneBody rod = Body(kRackClass, {1.6, 0.0, 0.0}, {1.65, 0.12, 0.06});
  MapStory story(PocdConfig());
  story.Look({FarWall(), rack}, 60);
  const Box place = Box(Eigen::Vector3d(1.5, 0.06, -0.1), Eigen::Vector3d(1.7, 0.2, 0.15));
  const std::size_t before = CountVoxelsIn(story.map(), place);
  story.Look({FarWall(), rack, rod}, 20);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kRackClass).size(), 1U);
  EXPECT_GT(CountVoxelsIn(story.map(), place), before);
}

TEST(ObjectMapper, KeepsABoxThatIsHidden) {
  const SceneBody rack = Body(kRackClass, {0.9, -2.0, -2.0}, {1.1, 2.0, 2.0});
  MapStory story(PocdConfig());
  story.Look({FarWall(), Goods(0.0)}, 20);
  story.Look({FarWall(), Goods(0.0), rack}, 40);
  EXPECT_TRUE(story.EventsOf(EventType::kRemoved, kGoodsClass).empty());
  EXPECT_EQ(story.Present(kGoodsClass).size(), 1U);
}

TEST(ObjectMapper, KeepsNothingOfAPerson) {
  const SceneBody person = Body(kPersonClass, {1.2, -0.2, -0.7}, {1.5, 0.2, 0.7});
  MapStory story(PocdConfig());
  story.Look({FarWall(), person}, 20);
  const Box place = Around(person, 0.2);
  EXPECT_EQ(CountVoxelsIn(story.map(), place), 0U);
  EXPECT_TRUE(story.EventsOf(EventType::kCreated, kPersonClass).empty());
  for (const auto& [id, object] : story.map().objects) {
    EXPECT_EQ(object->class_id, ClassId(kWallClass));
  }
}

TEST(ObjectMapper, PutsFramesWithoutLabelsIntoTheBackground) {
  std::vector<Frame> frames = LookAtScene({FarWall(), Goods(0.0)}, 0, 8);
  for (Frame& frame : frames) frame.labels = {};
  MapStory story(PocdConfig());
  story.Play(frames);
  EXPECT_TRUE(story.events().empty());
  EXPECT_TRUE(story.map().objects.empty());
  EXPECT_GT(CountVoxelsIn(story.map(), Goods(0.0).box_world), 0U);
}

/// Labels the pixels at the left and right borders of goods as ground. Also deletes their depth if
/// `leaves_out`.
void SpoilBordersOfGoods(Frame* frame, bool leaves_out) {
  constexpr int kBorderPx = 5;
  const Image<std::uint16_t> labels = frame->labels;
  for (int v = 0; v < frame->camera.height_px; ++v) {
    for (int u = kBorderPx; u + kBorderPx < frame->camera.width_px; ++u) {
      const bool is_inside =
          labels.At(u - kBorderPx, v) == kGoodsClass && labels.At(u + kBorderPx, v) == kGoodsClass;
      if (labels.At(u, v) != kGoodsClass || is_inside) continue;
      frame->labels.At(u, v) = 1;
      if (leaves_out) frame->depth.units.At(u, v) = 0;
    }
  }
}

TEST(ObjectMapper, LeavesNothingOfAThingWhoseEdgesHadTheLabelOfTheGround) {
  const SceneBody box = Goods(0.0);
  std::vector<Frame> frames = LookAtScene({FarWall(), box}, 0, 24);
  for (std::size_t i = 0; i < frames.size(); ++i) SpoilBordersOfGoods(&frames[i], i < 8);
  MapStory story(PocdConfig());
  story.Play(frames);
  EXPECT_EQ(CountBackgroundIn(story.map(), Around(box, 0.02)), 0U);
}

/// Labels the pixels of goods right of their centre as ground. Also deletes their depth if
/// `leaves_out`.
void SpoilHalfOfGoods(Frame* frame, bool leaves_out) {
  for (int v = 0; v < frame->camera.height_px; ++v) {
    int first = frame->camera.width_px;
    int last = -1;
    for (int u = 0; u < frame->camera.width_px; ++u) {
      if (frame->labels.At(u, v) != kGoodsClass) continue;
      first = std::min(first, u);
      last = u;
    }
    for (int u = (first + last) / 2; u <= last; ++u) {
      frame->labels.At(u, v) = 1;
      if (leaves_out) frame->depth.units.At(u, v) = 0;
    }
  }
}

TEST(ObjectMapper, LeavesNothingOfAThingOfWhichHalfHadTheLabelOfTheGround) {
  const SceneBody box = Goods(0.0);
  std::vector<Frame> frames = LookAtScene({FarWall(), box}, 0, 24);
  for (std::size_t i = 0; i < 10; ++i) SpoilHalfOfGoods(&frames[i], i < 8);
  MapStory story(PocdConfig());
  story.Play(frames);
  EXPECT_EQ(CountBackgroundIn(story.map(), Around(box, 0.02)), 0U);
}

/// Returns frames of a box that is added, moved and removed.
std::vector<Frame> EventfulFrames() {
  std::vector<Frame> frames = LookAtScene({FarWall()}, 0, 6);
  const auto append = [&](const Scene& scene, int count) {
    for (Frame& frame : LookAtScene(scene, static_cast<int>(frames.size()), count)) {
      frames.push_back(std::move(frame));
    }
  };
  append({FarWall(), Goods(-0.3)}, 20);
  append({FarWall(), Goods(0.3)}, 16);
  append({FarWall()}, 12);
  return frames;
}

TEST(ObjectMapper, GivesTheSameMapWhateverTheCommitRhythm) {
  const std::vector<Frame> frames = EventfulFrames();
  MapStory reference(PocdConfig());
  reference.Play(frames, 1);
  EXPECT_GE(reference.events().size(), 4U);
  for (const std::size_t frames_per_commit : {std::size_t{1}, std::size_t{5}, frames.size()}) {
    SCOPED_TRACE(frames_per_commit);
    MapStory story(PocdConfig());
    story.Play(frames, frames_per_commit);
    EXPECT_EQ(story.events(), reference.events());
    ExpectSameMap(story.map(), reference.map());
  }
}

/// Reduces a frame to returns in a central patch of `side_px`, without labels.
Frame Patch(Frame frame, int side_px) {
  frame.labels = {};
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      const int off_px = std::max(std::abs(u - frame.camera.width_px / 2),
                                  std::abs(v - frame.camera.height_px / 2));
      if (2 * off_px >= side_px) frame.depth.units.At(u, v) = kNoDepth;
    }
  }
  return frame;
}

/// Returns the commits for frames, one after every `frames_per_commit` frames.
std::vector<MapCommit> Commits(const std::vector<Frame>& frames, std::size_t frames_per_commit) {
  const std::unique_ptr<Mapper> mapper = Mapper::Create(PocdConfig()).value();
  std::vector<MapCommit> commits;
  for (const Frame& frame : frames) {
    mapper->Integrate(mapper->head().Next(), frame);
    if (mapper->uncommitted_entries() == frames_per_commit) commits.push_back(mapper->Commit());
  }
  return commits;
}

TEST(ObjectMapper, GoesOnFromARestoredMapAsIfNeverStopped) {
  const std::vector<Frame> frames = EventfulFrames();
  const std::vector<MapCommit> commits = Commits(frames, 4);
  MapSnapshot stored(commits.front().snapshot->scale);
  for (std::size_t i = 0; i + 1 < commits.size(); ++i) {
    ASSERT_TRUE(Apply(commits[i].delta, &stored).ok());
    ExpectSameMap(stored, *commits[i].snapshot);
    const std::unique_ptr<Mapper> restarted = Mapper::Create(PocdConfig()).value();
    restarted->Restore(stored);
    for (std::size_t frame = 4 * i + 4; frame < 4 * i + 8; ++frame) {
      restarted->Integrate(restarted->head().Next(), frames[frame]);
    }
    const MapCommit next = restarted->Commit();
    EXPECT_TRUE(next.delta == commits[i + 1].delta) << "restarted after commit " << i;
    ExpectSameMap(*next.snapshot, *commits[i + 1].snapshot);
  }
}

TEST(ObjectMapper, TellsInDeltasWhatSnapshotsShow) {
  const std::vector<MapCommit> commits = Commits(EventfulFrames(), 6);
  MapSnapshot before(commits.front().snapshot->scale);
  MapDelta all{.from = before.revision, .to = before.revision, .last_capture_time = {}};
  for (const MapCommit& commit : commits) {
    const MapDelta difference = Diff(before, *commit.snapshot);
    ASSERT_TRUE(Apply(difference, &before).ok());
    ExpectSameMap(before, *commit.snapshot);
    all = Merge(all, commit.delta);
  }
  MapSnapshot at_once(before.scale);
  ASSERT_TRUE(Apply(all, &at_once).ok());
  ExpectSameMap(at_once, *commits.back().snapshot);
  MapSnapshot nothing(before.scale);
  nothing.revision = at_once.revision.Next();
  ASSERT_TRUE(Apply(Diff(at_once, nothing), &at_once).ok());
  ExpectSameMap(at_once, nothing);
}

TEST(ObjectMapper, PublishesAnObjectOfWhichAFrameShowsLittle) {
  std::vector<Frame> frames = LookAtScene({FarWall(), Goods(0.0)}, 0, 7);
  const Frame whole = frames.back();
  for (int side_px = 8; side_px <= 32; side_px += 2) {
    SCOPED_TRACE(side_px);
    frames.back() = Patch(whole, side_px);
    MapStory step_by_step(PocdConfig());
    step_by_step.Play(frames, 1);
    MapStory at_once(PocdConfig());
    at_once.Play(frames, frames.size());
    ExpectSameMap(step_by_step.map(), at_once.map());
  }
}

TEST(ObjectMapper, TakesFramesOfAnySizeAndDepth) {
  for (const auto& [width_px, height_px] :
       {std::pair{1, 1}, {2, 1}, {4, 4}, {1, 300}, {10, 10}, {14, 12}, {16, 16}, {37, 5}}) {
    for (const double depth_m : {0.0, 0.001, 1.0, 2.0, 2.9, 65.5}) {
      SCOPED_TRACE(::testing::Message() << width_px << " x " << height_px << " at " << depth_m);
      MapStory story(PocdConfig());
      for (int i = 0; i < 6; ++i) story.Play({SmallFrame(width_px, height_px, depth_m, i)});
      EXPECT_EQ(story.map().revision, Revision(6));
      ExpectSameMap(story.told(), story.map());
    }
  }
}

TEST(ObjectMapper, TellsEveryLeafThatChanged) {
  MapStory story(PocdConfig());
  const std::vector<Frame> frames = EventfulFrames();
  for (std::size_t i = 0; i < frames.size(); i += 3) {
    SCOPED_TRACE(i);
    story.Play({frames.begin() + static_cast<std::ptrdiff_t>(i),
                frames.begin() + static_cast<std::ptrdiff_t>(i + 3)},
               2);
    ExpectSameMap(story.told(), story.map());
  }
}

}  // namespace
}  // namespace steadymap
