// Robots with pose jumps in the corner of a room, processed by maps of the pocd policy.

#include "core/robot/localization_monitor.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/map/map_delta.h"
#include "core/mapper.h"
#include "core/policy/evidence_mapper.h"
#include "tests/core/policy/map_story.h"
#include "tests/core/policy/room_drive.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::Drive;
using ::steadymap::testing::ExpectSameMap;
using ::steadymap::testing::From;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Mislead;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::Room;
using ::steadymap::testing::RoomWithout;
using ::steadymap::testing::Scene;

// Enough frames to observe the whole room and to establish belief in its objects.
constexpr int kMappingFrames = 70;

// Frames after which it is decided whether a robot is lost.
constexpr int kDecidingFrames = 10;

constexpr double kShiftM = 1.0;
constexpr double kTurnRad = 0.52;
constexpr double kPauseS = 3600.0;

std::vector<ObjectEvent> EventsOf(const MapStory& story, EventType type) {
  std::vector<ObjectEvent> found;
  for (const ObjectEvent& event : story.events()) {
    if (event.type == type) found.push_back(event);
  }
  return found;
}

SensorName CameraOf(const std::string& robot) { return {robot, SensorName::kDefaultSensor}; }

Trust TrustIn(const MapStory& story, const std::string& robot = "robot") {
  return story.map().robots.at(CameraOf(robot)).trust;
}

/// Maps the room in one session.
void MapRoom(MapStory* story) {
  story->Play(Drive(Room(), 0, kMappingFrames));
  story->EndSession(CameraOf("robot"));
}

/// Expects the content of a map to be unchanged, except for the robots.
void ExpectSameContent(MapSnapshot now, const MapSnapshot& before) {
  now.revision = before.revision;
  now.last_capture_time = before.last_capture_time;
  now.robots = before.robots;
  ExpectSameMap(now, before);
}

TEST(LocalizationMonitor, ARobotThatJumpsChangesNothingUntilItIsBack) {
  MapStory story(PocdConfig());
  MapRoom(&story);
  const MapSnapshot before = story.map();
  story.Play(Mislead(Drive(Room(), kMappingFrames, 12), kShiftM, kTurnRad));
  ExpectSameContent(story.map(), before);
  EXPECT_EQ(TrustIn(story), Trust::kLost);
  EXPECT_EQ(story.map().revision, Revision(kMappingFrames + 1 + 12))
      << "its frames are acknowledged";
  const std::vector<ObjectEvent> lost = EventsOf(story, EventType::kRobotLost);
  ASSERT_EQ(lost.size(), 1U);
  EXPECT_EQ(lost[0].reason, EventReason::kDisagreement);
  EXPECT_EQ(lost[0].source.robot, "robot");
  EXPECT_EQ(lost[0].object, ObjectId());
  EXPECT_LE(lost[0].revision, Revision(kMappingFrames + 1 + kDecidingFrames));

  story.Play(Drive(Room(), kMappingFrames + 12, 20));
  const std::vector<ObjectEvent> found = EventsOf(story, EventType::kRobotFound);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].reason, EventReason::kAgreement);
  EXPECT_EQ(found[0].source.robot, "robot");
  EXPECT_LE(found[0].revision, Revision(kMappingFrames + 1 + 12 + 3));
  EXPECT_EQ(TrustIn(story), Trust::kTrusted);
  story.EndSession(CameraOf("robot"));
  EXPECT_EQ(EventsOf(story, EventType::kRobotLost).size(), 1U);
  EXPECT_TRUE(EventsOf(story, EventType::kRemoved).empty());
  EXPECT_EQ(story.Present(kGoodsClass).size(), 4U);
}

TEST(LocalizationMonitor, WithoutItAJumpSpoilsTheMap) {
  EvidenceMapperParameters parameters;
  parameters.guard.is_on = false;
  EvidenceMapper mapper(PocdConfig(), parameters);
  WorkingMap map(PocdConfig());
  SemanticCloud cloud(PocdConfig());
  const auto take = [&](const std::vector<Frame>& frames) {
    for (const Frame& frame : frames) {
      cloud.Compute(frame);
      map.BeginFrame(map.revision().Next(), frame.capture_time);
      mapper.Process(frame, &cloud, &map);
      map.EndFrame();
    }
    return map.Commit();
  };
  take(Drive(Room(), 0, kMappingFrames));
  const MapCommit spoilt = take(Mislead(Drive(Room(), kMappingFrames, 12), kShiftM, kTurnRad));
  EXPECT_GT(spoilt.delta.leaves.size(), 100U);
}

TEST(LocalizationMonitor, ASingleWrongPoseIsLeftOutSilently) {
  MapStory story(PocdConfig());
  story.Play(Drive(Room(), 0, kMappingFrames));
  const MapSnapshot before = story.map();
  story.Play(Mislead(Drive(Room(), kMappingFrames, 1), kShiftM, kTurnRad));
  ExpectSameContent(story.map(), before);
  EXPECT_EQ(TrustIn(story), Trust::kDoubted);
  story.Play(Drive(Room(), kMappingFrames + 1, 1));
  EXPECT_EQ(TrustIn(story), Trust::kTrusted);
  EXPECT_TRUE(EventsOf(story, EventType::kRobotLost).empty());
}

TEST(LocalizationMonitor, TheFramesOfOtherRobotsGoOnToCount) {
  MapStory story(PocdConfig());
  MapRoom(&story);
  const std::vector<Frame> misled = Mislead(Drive(Room(), kMappingFrames, 30), kShiftM, kTurnRad);
  const std::vector<Frame> others = From("other", Drive(RoomWithout(2), kMappingFrames, 30));
  for (std::size_t i = 0; i < misled.size(); ++i) story.Play({misled[i], others[i]});
  story.EndSession(CameraOf("other"));
  ASSERT_EQ(EventsOf(story, EventType::kRobotLost).size(), 1U);
  EXPECT_EQ(EventsOf(story, EventType::kRobotLost)[0].source.robot, "robot");
  EXPECT_EQ(TrustIn(story), Trust::kLost);
  EXPECT_EQ(TrustIn(story, "other"), Trust::kTrusted);
  EXPECT_GE(EventsOf(story, EventType::kRemoved).size(), 1U);
  EXPECT_LT(story.Present(kGoodsClass).size(), 4U);
}

TEST(LocalizationMonitor, ARobotThatComesBackToAChangedRoomIsBelieved) {
  // The robot returns to its last pose or to another one. Half of the boxes are removed.
  for (const int first : {70, 85, 104}) {
    SCOPED_TRACE(first);
    MapStory story(PocdConfig());
    story.Play(Drive(Room(), 0, kMappingFrames), kMappingFrames);
    story.Play(Drive(RoomWithout(2), first, 45, kPauseS));
    story.EndSession(CameraOf("robot"));
    EXPECT_TRUE(EventsOf(story, EventType::kRobotLost).empty());
    EXPECT_EQ(TrustIn(story), Trust::kTrusted);
    EXPECT_EQ(EventsOf(story, EventType::kRemoved).size(), 2U);
    EXPECT_EQ(story.Present(kGoodsClass).size(), 2U);
  }
}

TEST(LocalizationMonitor, ARobotThatDrivesOnIsBelievedWhateverItSees) {
  MapStory story(PocdConfig());
  story.Play(Drive(Room(), 0, kMappingFrames));
  const Scene other = {Body(kWallClass, {1.3, -3.0, 0.0}, {1.5, 3.0, 2.5})};
  const MapSnapshot before = story.map();
  story.Play(Drive(other, kMappingFrames, 10));
  EXPECT_TRUE(EventsOf(story, EventType::kRobotLost).empty());
  EXPECT_EQ(TrustIn(story), Trust::kTrusted);
  EXPECT_FALSE(story.map().free_space == before.free_space);
}

TEST(LocalizationMonitor, ARobotInANewPlaceIsBelieved) {
  MapStory story(PocdConfig());
  MapRoom(&story);
  const std::size_t leaves = testing::PackedLeaves(story.map()).size();
  // Another room, 50 m away: first after a pause, then from a robot unknown to the map.
  std::vector<Frame> frames = Drive(RoomWithout(2), 10, 10, kPauseS);
  for (Frame& frame : frames) frame.T_world_camera.translation().x() += 50.0;
  story.Play(frames);
  EXPECT_EQ(TrustIn(story), Trust::kTrusted);
  const std::size_t more_leaves = testing::PackedLeaves(story.map()).size();
  EXPECT_GT(more_leaves, leaves + 100);
  for (Frame& frame : frames) frame.T_world_camera.translation().x() += 50.0;
  story.Play(From("stranger", frames));
  EXPECT_EQ(TrustIn(story, "stranger"), Trust::kTrusted);
  EXPECT_GT(testing::PackedLeaves(story.map()).size(), more_leaves + 100);
  EXPECT_TRUE(EventsOf(story, EventType::kRobotLost).empty());
}

TEST(LocalizationMonitor, ARobotThatWakesUpWithAWrongPoseIsLost) {
  MapStory story(PocdConfig());
  MapRoom(&story);
  const MapSnapshot before = story.map();
  story.Play(Mislead(Drive(Room(), kMappingFrames - 1, 10, kPauseS), kShiftM, kTurnRad));
  ExpectSameContent(story.map(), before);
  EXPECT_EQ(EventsOf(story, EventType::kRobotLost).size(), 1U);
}

TEST(LocalizationMonitor, ALostRobotIsFoundInAPlaceThatIsNewForLong) {
  MapStory story(PocdConfig());
  story.Play(Drive(Room(), 0, kMappingFrames));
  // Until the odds have risen from the lowest to the highest, by at most the odds of a new place.
  constexpr int kMostFramesInNewPlace = 200;
  std::vector<Frame> misled = Mislead(
      Drive(Room(), kMappingFrames, kDecidingFrames + kMostFramesInNewPlace), kShiftM, kTurnRad);
  const auto first_in_new_place = misled.begin() + kDecidingFrames;
  story.Play({misled.begin(), first_in_new_place});
  ASSERT_EQ(TrustIn(story), Trust::kLost);

  // The robot drives so far without returns that neither its reported nor its corrected position is
  // mapped.
  std::vector<Frame> on_the_way;
  const auto drive_on = [](Frame* frame, int steps) {
    frame->T_world_camera.translation().x() += 0.3 * steps;
    frame->capture_time = Timestamp::FromSeconds(frame->capture_time.seconds() + 0.2 * steps);
  };
  constexpr int kSteps = 170;
  for (int step = 1; step <= kSteps; ++step) {
    Frame frame = misled[kDecidingFrames - 1];
    frame.depth.units = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
    drive_on(&frame, step);
    on_the_way.push_back(std::move(frame));
  }
  story.Play(on_the_way, kSteps);
  EXPECT_EQ(TrustIn(story), Trust::kLost) << "frames that show nothing say nothing";
  std::for_each(first_in_new_place, misled.end(), [&](Frame& frame) { drive_on(&frame, kSteps); });
  story.Play({first_in_new_place, first_in_new_place + 10});
  EXPECT_EQ(TrustIn(story), Trust::kLost);
  story.Play({first_in_new_place + 10, misled.end()});
  EXPECT_EQ(TrustIn(story), Trust::kTrusted);
  EXPECT_EQ(EventsOf(story, EventType::kRobotFound).size(), 1U);
}

/// Returns a drive with one false pose, and later a period of false poses.
std::vector<Frame> EventfulDrive() {
  std::vector<Frame> frames = Drive(Room(), 0, 40);
  const auto append = [&frames](std::vector<Frame> more) {
    for (Frame& frame : more) frames.push_back(std::move(frame));
  };
  append(Mislead(Drive(Room(), 40, 1), kShiftM, kTurnRad));
  append(Drive(Room(), 41, 2));
  append(Mislead(Drive(Room(), 43, kDecidingFrames), -kShiftM, kTurnRad));
  append(Drive(Room(), 43 + kDecidingFrames, 6));
  return frames;
}

TEST(LocalizationMonitor, GoesOnFromARestoredMapAsIfNeverStopped) {
  const std::vector<Frame> frames = EventfulDrive();
  const std::unique_ptr<Mapper> mapper = Mapper::Create(PocdConfig()).value();
  MapSnapshot stored(VoxelScale{PocdConfig().voxel_size_m, PocdConfig().truncation_m});
  std::size_t events_of_robots = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    std::unique_ptr<Mapper> restarted;
    if (i >= 39) {
      restarted = Mapper::Create(PocdConfig()).value();
      restarted->Restore(stored);
      restarted->Integrate(restarted->head().Next(), frames[i]);
    }
    mapper->Integrate(mapper->head().Next(), frames[i]);
    const MapCommit commit = mapper->Commit();
    if (restarted != nullptr) {
      EXPECT_TRUE(restarted->Commit().delta == commit.delta) << "restarted before frame " << i;
      EXPECT_TRUE(Diff(stored, *commit.snapshot).robots == commit.delta.robots);
    }
    for (const ObjectEvent& event : commit.delta.events) {
      events_of_robots += event.IsOfRobot() ? 1U : 0U;
    }
    ASSERT_TRUE(Apply(commit.delta, &stored).ok());
    ASSERT_TRUE(stored.robots == commit.snapshot->robots);
  }
  EXPECT_EQ(events_of_robots, 2U);
}

TEST(LocalizationMonitor, GivesTheSameMapWhateverTheCommitRhythm) {
  const std::vector<Frame> frames = EventfulDrive();
  MapStory one_by_one(PocdConfig());
  one_by_one.Play(frames, 1);
  MapStory in_groups(PocdConfig());
  in_groups.Play(frames, 4);
  EXPECT_EQ(in_groups.events(), one_by_one.events());
  ExpectSameMap(in_groups.map(), one_by_one.map());
  ExpectSameMap(in_groups.told(), one_by_one.map());
}

/// Capture time from the first of misled frames until the robot is lost, seconds. There are
/// `copies` frames in the place of one.
double TimeUntilLost(int copies) {
  MapStory story(PocdConfig());
  MapRoom(&story);
  const std::vector<Frame> misled = Mislead(Drive(Room(), kMappingFrames, 12), kShiftM, kTurnRad);
  const double interval_s = (misled[1].capture_time - misled[0].capture_time).seconds();
  for (const Frame& frame : misled) {
    for (int copy = 0; copy < copies; ++copy) {
      Frame more = frame;
      more.capture_time =
          Timestamp::FromSeconds(frame.capture_time.seconds() + copy * interval_s / copies);
      story.Play({more});
      if (TrustIn(story) == Trust::kLost) {
        return (more.capture_time - misled[0].capture_time).seconds();
      }
    }
  }
  ADD_FAILURE() << "never lost";
  return 0.0;
}

TEST(LocalizationMonitor, ManyFramesOfOneLookWeighAsOne) {
  EXPECT_NEAR(TimeUntilLost(6), TimeUntilLost(1), 0.25);
}

TEST(LocalizationMonitor, AJumpAlongABareWallIsBelieved) {
  const Scene wall = {Body(kWallClass, {1.3, -12.0, 0.0}, {1.5, 12.0, 2.5})};
  MapStory story(PocdConfig());
  story.Play(Drive(wall, 0, 100), 100);
  std::vector<Frame> frames = Drive(wall, 100, 20);
  for (Frame& frame : frames) frame.T_world_camera.translation().y() -= 1.0;
  story.Play(frames);
  EXPECT_EQ(TrustIn(story), Trust::kTrusted);
  EXPECT_TRUE(EventsOf(story, EventType::kRobotLost).empty());
}

TEST(LocalizationMonitor, TakesAnyPoseAtAnyTime) {
  MapStory story(PocdConfig());
  std::vector<Frame> frames = Drive(Room(), 0, 12);
  const double limit_m = kMaxPositionM - 1.0;
  frames[2].T_world_camera.translation().setConstant(0.5 * limit_m);
  frames[3].T_world_camera.linear() =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  frames[4].T_world_camera.linear().setIdentity();
  frames[5].capture_time = frames[4].capture_time;
  frames[6].capture_time = Timestamp::FromNanoseconds(std::numeric_limits<std::int64_t>::max());
  frames[7].capture_time = Timestamp::FromNanoseconds(std::numeric_limits<std::int64_t>::min());
  frames[8].source.robot.clear();
  frames[10].T_world_camera.translation().setConstant(-0.5 * limit_m);
  frames[9].capture_time = Timestamp::FromNanoseconds(frames[8].capture_time.nanoseconds() + 1);
  story.Play(frames);
  EXPECT_EQ(story.map().revision, Revision(12));
  EXPECT_EQ(story.map().robots.size(), 2U);
  ExpectSameMap(story.told(), story.map());
  for (const auto& [name, robot] : story.map().robots) {
    EXPECT_TRUE(robot.claimed.position_world.allFinite()) << name.ToString();
    EXPECT_TRUE(robot.likely.position_world.allFinite()) << name.ToString();
    EXPECT_TRUE(robot.velocity_m_per_s.allFinite()) << name.ToString();
    EXPECT_TRUE(robot.turn_rad_per_s.allFinite()) << name.ToString();
  }
}

TEST(WorkingMap, ForgetsTheRobotSeenLongestAgo) {
  constexpr int kMostRobots = 1000;
  WorkingMap map(PocdConfig());
  map.BeginFrame(Revision(1), Timestamp::FromSeconds(1.0));
  const auto store = [&map](int i, double last_seen_s) {
    RobotState state;
    state.last_capture_time = Timestamp::FromSeconds(last_seen_s);
    map.StoreRobot({"robot-" + std::to_string(i), "camera"}, state);
  };
  for (int i = 0; i < kMostRobots; ++i) store(i, 1000.0 + (i == 7 ? -1 : i));
  const MapCommit full = map.Commit();
  EXPECT_EQ(full.snapshot->robots.size(), static_cast<std::size_t>(kMostRobots));
  map.BeginFrame(Revision(2), Timestamp::FromSeconds(2.0));
  store(kMostRobots, 5000.0);
  const MapCommit next = map.Commit();
  EXPECT_EQ(next.snapshot->robots.size(), static_cast<std::size_t>(kMostRobots));
  EXPECT_EQ(map.FindRobot({"robot-7", "camera"}), nullptr);
  ASSERT_EQ(next.delta.robots.size(), 2U);
  EXPECT_EQ(next.delta.robots[0].sensor.robot, "robot-1000");
  EXPECT_EQ(next.delta.robots[1], (RobotChange{{"robot-7", "camera"}, std::nullopt}));
  EXPECT_TRUE(Diff(*full.snapshot, *next.snapshot).robots == next.delta.robots);
  MapSnapshot told(full.snapshot->scale);
  ASSERT_TRUE(Apply(Merge(full.delta, next.delta), &told).ok());
  EXPECT_TRUE(told.robots == next.snapshot->robots);
}

}  // namespace
}  // namespace steadymap
