#include "client/bench/evaluation/room/room_score.h"

#include <algorithm>
#include <memory>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// A map and events that agree with the truth of a room.
struct PerfectMap {
  explicit PerfectMap(const BoxRoom& room) {
    std::uint64_t id = 0;
    for (const RoomObject& truth : room.objects) {
      auto object = std::make_shared<MapObject>();
      object->id = ObjectId(++id);
      object->status = ObjectStatus::kPresent;
      object->class_id = truth.class_id;
      object->cuboid = {truth.box_world.center(), truth.box_world.sizes(), 0.0};
      object->volume = std::make_shared<TsdfGrid>();
      objects.push_back(object);
    }
    for (const RoomEvent& truth : room.events) {
      ObjectEvent event;
      event.type = truth.type;
      event.class_id = truth.class_id;
      event.center_world = truth.box_world.center();
      events.push_back(event);
    }
  }

  MapSnapshot Snapshot() const {
    MapSnapshot map;
    for (const auto& object : objects) map.objects.insert_or_assign(object->id, object);
    return map;
  }

  std::vector<std::shared_ptr<MapObject>> objects;
  std::vector<ObjectEvent> events;
};

class ScoreRoomTest : public ::testing::Test {
 protected:
  RoomScore Score(const RoomTolerance& tolerance = {}) const {
    return ScoreRoom(room_, map_.events, map_.Snapshot(), tolerance);
  }

  const BoxRoom room_ = MakeBoxRoom(RoomChange::kMoved30Cm, {});
  PerfectMap map_{room_};
};

TEST_F(ScoreRoomTest, IsExactForTheTruth) {
  EXPECT_TRUE(Score().is_exact());
  EXPECT_LT(Score().worst_cuboid_m, 1e-9);
}

TEST_F(ScoreRoomTest, ADuplicateEventIsAFault) {
  map_.events.push_back(map_.events.back());
  EXPECT_EQ(Score().event_faults.size(), 1U);
  EXPECT_FALSE(Score().is_exact());
}

TEST_F(ScoreRoomTest, ARemovalAndACreationAreNoMove) {
  ObjectEvent& moved = map_.events.back();
  ASSERT_EQ(moved.type, EventType::kMoved);
  moved.type = EventType::kCreated;
  map_.events.push_back(moved);
  map_.events.back().type = EventType::kRemoved;
  EXPECT_EQ(Score().event_faults.size(), 3U);
}

TEST_F(ScoreRoomTest, AnEventBesideItsPlaceIsMissingAndTooMany) {
  map_.events.back().center_world.x() += 0.2;
  EXPECT_EQ(Score().event_faults.size(), 2U);
}

// The event of the upper box of a stack, listed first, is also near enough to the lower box.
TEST(ScoreRoom, MatchesStackedThingsWhateverTheOrderOfTheEvents) {
  const BoxRoom room = MakeBoxRoom(RoomChange::kUpperRemoved, {});
  PerfectMap map(room);
  for (ObjectEvent& event : map.events) {
    if (event.type == EventType::kCreated) event.center_world.z() -= 0.05;
  }
  std::reverse(map.events.begin(), map.events.end());
  EXPECT_TRUE(ScoreRoom(room, map.events, map.Snapshot(), {}).is_exact());
  std::reverse(map.events.begin(), map.events.end());
  EXPECT_TRUE(ScoreRoom(room, map.events, map.Snapshot(), {}).is_exact());
}

TEST_F(ScoreRoomTest, PiecesThatJoinSilentlyAndPiecesOfTheWallAreNoFaults) {
  ObjectEvent piece = map_.events.back();
  piece.type = EventType::kUpdated;
  map_.events.push_back(piece);
  piece.type = EventType::kCreated;
  piece.class_id = room_.wall_class;
  map_.events.push_back(piece);
  EXPECT_TRUE(Score().is_exact());
  EXPECT_FALSE(Score({.compares_classes = false}).is_exact());
  map_.events.back().center_world = room_.wall_world.center();
  EXPECT_TRUE(Score({.compares_classes = false}).is_exact());
}

TEST_F(ScoreRoomTest, ObjectsMustBeJustTheTrueOnes) {
  map_.objects.pop_back();
  EXPECT_EQ(Score().object_faults.size(), 1U);
  map_ = PerfectMap(room_);
  map_.objects.push_back(std::make_shared<MapObject>(*map_.objects.back()));
  map_.objects.back()->id = ObjectId(99);
  EXPECT_EQ(Score().object_faults.size(), 1U);
  map_.objects.back()->status = ObjectStatus::kArchived;
  EXPECT_TRUE(Score().is_exact());
}

TEST_F(ScoreRoomTest, FurnitureAtTheBorderOfTheViewMayBeMissingButNotDoubled) {
  const auto is_optional = [](const auto& truth) { return !truth.is_required; };
  const auto object = std::find_if(room_.objects.begin(), room_.objects.end(), is_optional);
  const auto event = std::find_if(room_.events.begin(), room_.events.end(), is_optional);
  ASSERT_NE(object, room_.objects.end());
  ASSERT_NE(event, room_.events.end());
  map_.objects.push_back(map_.objects[static_cast<std::size_t>(object - room_.objects.begin())]);
  map_.objects.back() = std::make_shared<MapObject>(*map_.objects.back());
  map_.objects.back()->id = ObjectId(99);
  EXPECT_EQ(Score().object_faults.size(), 1U);
  map_ = PerfectMap(room_);
  map_.objects.erase(map_.objects.begin() + (object - room_.objects.begin()));
  map_.events.erase(map_.events.begin() + (event - room_.events.begin()));
  EXPECT_TRUE(Score().is_exact());
}

TEST_F(ScoreRoomTest, MeasuresTheWorstFaceOfTheCuboids) {
  map_.objects.back()->cuboid.size_m.x() += 0.16;
  EXPECT_NEAR(Score().worst_cuboid_m, 0.08, 1e-9);
}

TEST_F(ScoreRoomTest, ClassesCountUnlessTheFramesHaveNone) {
  map_.objects.back()->class_id = ClassId(12);
  EXPECT_FALSE(Score().is_exact());
  EXPECT_TRUE(Score({.compares_classes = false}).is_exact());
}

}  // namespace
}  // namespace steadymap
