// Tests the store's contract for objects, events, free space and robots.

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/store/database/object_records.h"
#include "server/store/database/robot_records.h"
#include "tests/server/store/store_contract.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

class StoreObjects : public StoreContract {
 protected:
  StoreOptions SmallOptionsWithFewEvents() {
    StoreOptions options = SmallOptions();
    options.kept_events = 4;
    return options;
  }

  StoreObjects() { options_ = SmallOptionsWithFewEvents(); }

  std::vector<StoredEvent> Events(MapKey map, std::uint64_t first = 1, std::size_t limit = 99) {
    absl::StatusOr<std::vector<StoredEvent>> events =
        store_->ReadEvents(map, EventNumber{first}, limit);
    EXPECT_TRUE(events.ok()) << events.status();
    return events.ok() ? *std::move(events) : std::vector<StoredEvent>();
  }
};

LeafChange LeafOfObject(std::uint64_t object, std::int32_t x, std::uint32_t seed) {
  LeafChange leaf = MakeLeaf(x, 0, 0, seed);
  leaf.key.object = ObjectId{object};
  return leaf;
}

MapDelta FirstDelta() {
  MapDelta delta =
      MakeDelta(0, 2, {MakeLeaf(1, 2, 3, 1), LeafOfObject(1, 5, 2), LeafOfObject(4, -5, 3)});
  delta.newest_object = ObjectId{6};
  delta.objects = {{ObjectId{1}, MakeObject(1, 11)}, {ObjectId{4}, MakeObject(4, 14)}};
  delta.free_blocks = {{{-64, 8, 0}, FreeBlock{{1, 0, 0, 0, 0, 0, 0, ~std::uint64_t{0}}}},
                       {{0, 0, 0}, FreeBlock{{0, 2}, {0, 2}, Timestamp::FromSeconds(100.0)}}};
  delta.robots = {{{"robot-1", "camera"}, MakeRobot(Trust::kTrusted, 31)},
                  {{"robot-2", "camera"}, MakeRobot(Trust::kDoubted, 32)},
                  {{"robot-3", "camera"}, MakeRobot(Trust::kLost, 33)},
                  {{"robot-4", "camera"}, MakeRobot(Trust::kTrusted, 34)}};
  delta.events = {MakeEvent(EventType::kCreated, 1, 21),
                  MakeEvent(EventType::kMoved, 4, 22),
                  MakeEvent(EventType::kRobotFound, 0, 23)};
  return delta;
}

TEST_P(StoreObjects, SurviveARestartBitForBit) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 4));
  const MapDelta first = FirstDelta();
  Commit(map.key, first);
  MapDelta second = MakeDelta(2, 4, {LeafOfObject(1, 5, 9), {{ObjectId{4}, {-40, 0, 0}}, {}}});
  second.newest_object = ObjectId{7};
  second.objects = {{ObjectId{1}, MakeObject(1, 111)}, {ObjectId{4}, std::nullopt}};
  second.free_blocks = {{{0, 0, 0}, FreeBlock{{0, 3}, {0, 1}, Timestamp::FromSeconds(200.0)}}};
  second.robots = {{{"robot-1", "camera"}, MakeRobot(Trust::kDoubted, 131)},
                   {{"robot-4", "camera"}, std::nullopt}};
  second.events = {MakeEvent(EventType::kRemoved, 4, 24)};
  Commit(map.key, second);
  Reopen();

  MapSnapshot expected({0.04, 0.12});
  ASSERT_TRUE(Apply(first, &expected).ok());
  ASSERT_TRUE(Apply(second, &expected).ok());
  const MapSnapshot loaded = Load(map).snapshot;
  EXPECT_EQ(loaded.newest_object, ObjectId{7});
  EXPECT_EQ(loaded.free_space, expected.free_space);
  const std::map<SensorName, RobotState> robots = {
      {{"robot-1", "camera"}, MakeRobot(Trust::kDoubted, 131)},
      {{"robot-2", "camera"}, MakeRobot(Trust::kDoubted, 32)},
      {{"robot-3", "camera"}, MakeRobot(Trust::kLost, 33)}};
  EXPECT_TRUE(loaded.robots == robots);
  EXPECT_TRUE(expected.robots == robots);
  ASSERT_EQ(loaded.objects.size(), 1U);
  EXPECT_EQ(static_cast<const ObjectState&>(*loaded.objects.at(ObjectId{1})), MakeObject(1, 111));
  EXPECT_EQ(LeavesOf(loaded), LeavesOf(expected));
  EXPECT_EQ(LeavesOf(loaded).size(), 2U);

  const std::vector<StoredEvent> events = Events(map.key);
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(events[0], (StoredEvent{EventNumber{1}, first.events[0]}));
  EXPECT_EQ(events[1], (StoredEvent{EventNumber{2}, first.events[1]}));
  EXPECT_EQ(events[2], (StoredEvent{EventNumber{3}, first.events[2]}));
  EXPECT_EQ(events[3], (StoredEvent{EventNumber{4}, second.events[0]}));
}

TEST_P(StoreObjects, EventsAreReadFromAnyNumberOn) {
  const MapRecord map = Create("hall");
  const MapRecord other = Create("yard");
  Append(MakeAppend(map.key, 1, 2));
  Append(MakeAppend(other.key, 1, 2));
  Commit(map.key, FirstDelta());
  Commit(other.key, FirstDelta());
  EXPECT_EQ(Events(map.key, 2).size(), 2U);
  EXPECT_EQ(Events(map.key, 2, 1).size(), 1U);
  EXPECT_EQ(Events(map.key, 2, 1).front().number, EventNumber{2});
  EXPECT_TRUE(Events(map.key, 4).empty());
  EXPECT_EQ(Events(map.key, 0).size(), 3U);
}

TEST_P(StoreObjects, OldEventsAreTrimmedAndNumbersGoOn) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 9));
  Commit(map.key, FirstDelta());
  for (std::uint64_t revision = 3; revision <= 9; ++revision) {
    MapDelta delta = MakeDelta(revision - 1, revision, {});
    delta.newest_object = ObjectId{6};
    delta.events = {MakeEvent(EventType::kUpdated, 1, 30)};
    Commit(map.key, delta);
    ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  }
  Reopen();
  const std::vector<StoredEvent> events = Events(map.key);
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(events.front().number, EventNumber{7});
  EXPECT_EQ(events.back().number, EventNumber{10});
}

INSTANTIATE_TEST_SUITE_P(All,
                         StoreObjects,
                         ::testing::Values(StoreKind::kRocks, StoreKind::kMemory),
                         NameOfStore);

TEST(ObjectRecords, RefuseWhatCannotHaveBeenWritten) {
  const storage::v1::ObjectState good = ToProto(MakeObject(5, 1));
  ASSERT_TRUE(FromProto(ObjectId{5}, good).ok());
  const auto refuse = [&](auto change) {
    storage::v1::ObjectState bad = good;
    change(&bad);
    const absl::Status status = FromProto(ObjectId{5}, bad).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << bad.ShortDebugString();
  };
  refuse([](storage::v1::ObjectState* state) { state->set_standing(0); });
  refuse([](storage::v1::ObjectState* state) { state->set_standing(4); });
  refuse([](storage::v1::ObjectState* state) { state->set_class_id(65536); });
  refuse([](storage::v1::ObjectState* state) { state->mutable_pose()->RemoveLast(); });
  refuse([](storage::v1::ObjectState* state) { state->add_cuboid(1.0); });
  refuse([](storage::v1::ObjectState* state) { state->clear_evidence_cells(); });
  refuse([](storage::v1::ObjectState* state) {
    state->set_evidence_cells(1, std::numeric_limits<double>::quiet_NaN());
  });
  refuse([](storage::v1::ObjectState* state) { state->mutable_belief()->set_alpha(0.0); });
  refuse([](storage::v1::ObjectState* state) { state->mutable_votes(0)->set_class_id(70000); });
  refuse([](storage::v1::ObjectState* state) {
    state->mutable_evidence(0)->set_scores(std::string(65, 'x'));
  });
  refuse([](storage::v1::ObjectState* state) { state->mutable_evidence(0)->set_x(1 << 30); });
  refuse([](storage::v1::ObjectState* state) { *state->add_evidence() = state->evidence(0); });
  refuse([](storage::v1::ObjectState* state) { *state->add_looks() = state->looks(0); });
  refuse([](storage::v1::ObjectState* state) {
    storage::v1::SessionLooks* looks = state->mutable_looks(0);
    *looks->add_evidence() = looks->evidence(0);
  });
  refuse([](storage::v1::ObjectState* state) {
    for (int i = 3; i < 10; ++i) state->add_looks()->set_robot("robot-" + std::to_string(i));
  });
  refuse([](storage::v1::ObjectState* state) {
    for (int i = 1; i < 9; ++i) *state->add_contradictions() = state->contradictions(0);
  });
  refuse([](storage::v1::ObjectState* state) { state->mutable_gaps(0)->clear_middle(); });
  refuse([](storage::v1::ObjectState* state) { state->mutable_gaps(0)->set_weight(0.0); });
  refuse([](storage::v1::ObjectState* state) {
    state->mutable_gaps(0)->set_middle(1, std::numeric_limits<double>::quiet_NaN());
  });
  refuse([](storage::v1::ObjectState* state) { *state->add_gaps() = state->gaps(0); });
}

TEST(ObjectRecords, MayHaveTheFurtherNumbersOfOlderOnes) {
  const ObjectState state = MakeObject(5, 1);
  storage::v1::ObjectState older = ToProto(state);
  older.add_evidence_cells(3.0);
  older.add_evidence_cells(0.5);
  EXPECT_EQ(FromProto(ObjectId{5}, older).value(), state);
}

TEST(EventRecords, NameTheSensorOfAContradiction) {
  const ObjectEvent event = MakeEvent(EventType::kContradicted, 4, 1);
  ASSERT_FALSE(event.source.robot.empty());
  EXPECT_EQ(FromProto(ToProto(event)).value(), event);
}

TEST(EventRecords, RefuseWhatCannotHaveBeenWritten) {
  const storage::v1::EventRecord good = ToProto(MakeEvent(EventType::kMoved, 4, 1));
  ASSERT_TRUE(FromProto(good).ok());
  const auto refuse = [&](auto change) {
    storage::v1::EventRecord bad = good;
    change(&bad);
    EXPECT_EQ(FromProto(bad).status().code(), absl::StatusCode::kDataLoss)
        << bad.ShortDebugString();
  };
  refuse([](storage::v1::EventRecord* event) { event->set_type(0); });
  refuse([](storage::v1::EventRecord* event) { event->set_type(11); });
  refuse([](storage::v1::EventRecord* event) { event->set_reason(10); });
  refuse([](storage::v1::EventRecord* event) { event->set_class_id(65536); });
  refuse([](storage::v1::EventRecord* event) { event->clear_center(); });
  refuse([](storage::v1::EventRecord* event) { event->mutable_old_center()->RemoveLast(); });
}

TEST(RobotRecords, RefuseWhatCannotHaveBeenWritten) {
  const storage::v1::RobotRecord good = ToProto(MakeRobot(Trust::kDoubted, 1));
  ASSERT_TRUE(FromProto(good).ok());
  const auto refuse = [&](auto change) {
    storage::v1::RobotRecord bad = good;
    change(&bad);
    EXPECT_EQ(FromProto(bad).status().code(), absl::StatusCode::kDataLoss)
        << bad.ShortDebugString();
  };
  const float not_a_number = std::numeric_limits<float>::quiet_NaN();
  refuse([](storage::v1::RobotRecord* robot) { robot->set_trust(0); });
  refuse([](storage::v1::RobotRecord* robot) { robot->set_trust(4); });
  refuse([](storage::v1::RobotRecord* robot) { robot->clear_claimed(); });
  refuse([](storage::v1::RobotRecord* robot) { robot->mutable_claimed()->add_position(1.0); });
  refuse([](storage::v1::RobotRecord* robot) {
    robot->mutable_likely()->mutable_rotation()->RemoveLast();
  });
  refuse([=](storage::v1::RobotRecord* robot) {
    robot->mutable_likely()->set_rotation(1, not_a_number);
  });
  refuse([](storage::v1::RobotRecord* robot) { robot->mutable_motion()->RemoveLast(); });
  refuse([=](storage::v1::RobotRecord* robot) { robot->set_motion(5, not_a_number); });
  refuse([](storage::v1::RobotRecord* robot) { *robot->add_moving() = robot->moving(0); });
  refuse([](storage::v1::RobotRecord* robot) { robot->mutable_offset()->add_center(1.0); });
  refuse([](storage::v1::RobotRecord* robot) { robot->mutable_offset()->clear_shift(); });
  refuse([](storage::v1::RobotRecord* robot) { robot->mutable_offset()->set_anchors(0); });
  refuse([](storage::v1::RobotRecord* robot) {
    robot->mutable_offset()->mutable_covariance()->RemoveLast();
  });
  refuse([=](storage::v1::RobotRecord* robot) {
    robot->mutable_offset()->set_covariance(9, static_cast<double>(not_a_number));
  });
  refuse([=](storage::v1::RobotRecord* robot) {
    robot->mutable_offset()->set_yaw(static_cast<double>(not_a_number));
  });
}

TEST(FreeBlockRecords, RefuseWhatCannotHaveBeenWritten) {
  const FreeBlock block{{1, 2, 3}, {1, 0, 2}, Timestamp::FromSeconds(100.0)};
  const storage::v1::FreeBlockRecord record = ToProto(block);
  EXPECT_EQ(*FromProto(record), block);
  const auto refuse = [&](const std::function<void(storage::v1::FreeBlockRecord*)>& damage) {
    storage::v1::FreeBlockRecord damaged = record;
    damage(&damaged);
    EXPECT_EQ(FromProto(damaged).status().code(), absl::StatusCode::kDataLoss);
  };
  refuse([](storage::v1::FreeBlockRecord* damaged) { damaged->add_cells(4); });
  refuse([](storage::v1::FreeBlockRecord* damaged) { damaged->add_recent(4); });
  refuse([](storage::v1::FreeBlockRecord* damaged) { damaged->set_recent(0, 4); });
}

TEST(FreeBlockRecords, WithoutRecentCellsAreOfAnOlderStore) {
  storage::v1::FreeBlockRecord record = ToProto(FreeBlock{{1, 2, 3}});
  EXPECT_EQ(record.recent_size(), 0);
  EXPECT_EQ(*FromProto(record), (FreeBlock{{1, 2, 3}}));
}

}  // namespace
}  // namespace steadymap
