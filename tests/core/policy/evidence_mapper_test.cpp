// Visits to a scene of goods in front of a wall.

#include "core/policy/evidence_mapper.h"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/policy/map_story.h"
#include "tests/core/policy/room_drive.h"

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

constexpr int kFrames = 10;

constexpr std::uint16_t kFloorClass = 1;
constexpr std::uint16_t kTableClass = 8;

const SensorName kOne{"one", SensorName::kDefaultSensor};
const SensorName kOther{"other", SensorName::kDefaultSensor};

/// Returns the same frames, taken by another sensor.
std::vector<Frame> TakenBy(const SensorName& source, std::vector<Frame> frames) {
  for (Frame& frame : frames) frame.source = source;
  return frames;
}

class EvidenceMapperTest : public ::testing::Test {
 protected:
  /// Looks at a scene for one session.
  void Visit(const testing::Scene& scene) {
    story_.Look(scene, kFrames, visit_++);
    story_.EndSession();
  }

  /// The same by a robot.
  void VisitBy(const SensorName& source, const testing::Scene& scene) {
    story_.Play(TakenBy(source, LookAtScene(scene, visit_ * kFrames, kFrames, visit_)));
    story_.EndSession(source);
    ++visit_;
  }

  void VisitWithoutLabels(const testing::Scene& scene) {
    std::vector<Frame> frames =
        testing::LookAtScene(scene, visit_ * (kFrames + 1), kFrames, visit_);
    for (Frame& frame : frames) frame.labels = {};
    story_.Play(frames);
    story_.EndSession();
    ++visit_;
  }

  MapStory story_{PocdConfig()};
  int visit_ = 0;
};

TEST_F(EvidenceMapperTest, AnObjectIsAnnouncedOnceAtTheEndOfItsSession) {
  story_.Look({FarWall(), Goods(0.0)}, kFrames);
  EXPECT_TRUE(story_.events().empty());
  story_.EndSession();
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, APauseEndsASessionAtTheTimeOfItsLastFrame) {
  const std::vector<Frame> first = LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames);
  story_.Play(first);
  EXPECT_TRUE(story_.events().empty());
  story_.Look({FarWall(), Goods(0.0)}, 1, 1);
  const std::vector<ObjectEvent> created = story_.EventsOf(EventType::kCreated, kGoodsClass);
  ASSERT_EQ(created.size(), 1U);
  EXPECT_EQ(created[0].time, first.back().capture_time);
  EXPECT_EQ(created[0].revision, Revision(kFrames + 1));
}

TEST_F(EvidenceMapperTest, AJumpBackInTimeEndsASession) {
  story_.Look({FarWall(), Goods(0.0)}, kFrames, 1);
  story_.Play(LookAtScene({FarWall(), Goods(0.0)}, 0, 1));
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, ALongSessionIsDecidedInParts) {
  MapConfig config = PocdConfig();
  config.parameters = {{"max_session_s", 4.0}};
  MapStory story(config);
  story.Look({FarWall(), Goods(0.0)}, kFrames);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  story.Look({FarWall(), Goods(0.0)}, 2 * kFrames);
  EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story.Present(kGoodsClass).size(), 1U);
}

/// Returns frames of goods, of nothing, as if the robot had looked elsewhere, and of the place
/// without the goods; all of one session.
std::vector<Frame> GoodsThatLeaveMeanwhile(int frames_elsewhere) {
  std::vector<Frame> frames = LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames);
  for (Frame& frame : LookAtScene({FarWall()}, kFrames, frames_elsewhere)) {
    frame.depth.units = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px, 0);
    frames.push_back(std::move(frame));
  }
  const std::vector<Frame> after = LookAtScene({FarWall()}, kFrames + frames_elsewhere, kFrames);
  frames.insert(frames.end(), after.begin(), after.end());
  return frames;
}

TEST_F(EvidenceMapperTest, ASessionEndsWhereTheRobotReturnsAndAThingHasLeft) {
  story_.Play(GoodsThatLeaveMeanwhile(30));
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, AThingThatLeavesWithoutAPauseEndsNoSession) {
  story_.Play(GoodsThatLeaveMeanwhile(5));
  EXPECT_TRUE(story_.EventsOf(EventType::kCreated, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, AnEndWithoutFramesTellsNothing) {
  Visit({FarWall(), Goods(0.0)});
  const std::size_t told = story_.events().size();
  story_.EndSession();
  story_.EndSession();
  EXPECT_EQ(story_.events().size(), told);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, TheStateOfARobotTellsWhetherItsSessionIsOpen) {
  const std::vector<Frame> frames = LookAtScene({FarWall()}, 0, 2);
  story_.Play(frames);
  const SensorName& sensor = frames.front().source;
  EXPECT_EQ(story_.map().robots.at(sensor).session_start, frames.front().capture_time);
  story_.EndSession(sensor);
  EXPECT_EQ(story_.map().robots.at(sensor).session_start, std::nullopt);
}

/// Returns the frames of a robot whose poses are off.
std::vector<Frame> WithOffset(const Eigen::Vector3d& shift_world, std::vector<Frame> frames) {
  for (Frame& frame : frames) frame.T_world_camera.pretranslate(shift_world);
  return frames;
}

TEST_F(EvidenceMapperTest, TheOffsetOfASessionIsStateOfItsSensor) {
  const Scene scene = {FarWall(), Goods(-0.7), Goods(0.7)};
  story_.Play(TakenBy(kOne, LookAtScene(scene, 0, kFrames)));
  story_.EndSession(kOne);
  EXPECT_EQ(story_.map().robots.at(kOne).offset, std::nullopt) << "nothing was known";
  const Eigen::Vector3d error_m(-0.05, 0.0, 0.0);
  const std::vector<Frame> frames =
      TakenBy(kOther, WithOffset(error_m, LookAtScene(scene, kFrames, kFrames, 1)));
  story_.Play(frames);
  story_.EndSession(kOther);
  const std::optional<PoseOffset>& offset = story_.map().robots.at(kOther).offset;
  ASSERT_TRUE(offset.has_value());
  EXPECT_EQ(offset->time, frames.back().capture_time);
  EXPECT_GE(offset->anchors, 2U);
  EXPECT_NEAR(offset->shift_world.x(), -error_m.x(), 3.0 * std::sqrt(offset->covariance(0, 0)));
  EXPECT_NEAR(offset->shift_world.x(), -error_m.x(), 0.015);
  EXPECT_EQ(story_.map().robots.at(kOne).offset, std::nullopt);
  EXPECT_EQ(story_.told().robots.at(kOther).offset, offset);

  // The next session finds its own.
  story_.Play(TakenBy(kOther, LookAtScene(scene, 2 * kFrames, kFrames, 2)));
  story_.EndSession(kOther);
  ASSERT_TRUE(story_.map().robots.at(kOther).offset.has_value());
  EXPECT_NEAR(story_.map().robots.at(kOther).offset->shift_world.x(), 0.0, 0.015);
}

TEST_F(EvidenceMapperTest, ExactPosesAreNotCorrected) {
  for (const double sigma_m : {0.0, 1e-200}) {
    MapConfig config = PocdConfig();
    config.parameters = {{"pose_error_m", sigma_m}};
    MapStory story(config);
    story.Play(TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames)));
    EXPECT_EQ(story.map().robots.at(kOne).pose_error, std::nullopt);
  }
}

TEST_F(EvidenceMapperTest, SmallErrorsOfPosesStayFinite) {
  MapConfig config = PocdConfig();
  config.parameters = {
      {"pose_error_m", 1e-4}, {"pose_error_rad", 0.5}, {"pose_error_time_s", 86'400.0}};
  MapStory story(config);
  story.Play(TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames)));
  const std::optional<PoseErrorEstimate>& estimate = story.map().robots.at(kOne).pose_error;
  ASSERT_TRUE(estimate.has_value());
  const PoseError error = estimate->Combined();
  EXPECT_LT(error.mean.head<3>().norm(), 0.001);
  EXPECT_GT(error.covariance.diagonal().minCoeff(), 0.0);
}

TEST_F(EvidenceMapperTest, ARobotWithAConstantOffsetOfTenCentimetresChangesNothing) {
  story_.Play(testing::From("one", testing::Drive(testing::Room(), 0, 60)));
  story_.EndSession(kOne);
  const std::size_t told = story_.events().size();
  story_.Play(testing::From(
      "other", testing::Mislead(testing::Drive(testing::Room(), 0, 60, 60.0), 0.1, 0.0)));
  story_.EndSession(kOther);
  for (std::size_t i = told; i < story_.events().size(); ++i) {
    const ObjectEvent& event = story_.events()[i];
    ADD_FAILURE() << "event of type " << static_cast<int>(event.type) << " of object "
                  << event.object.value() << " of class " << event.class_id.value() << " at "
                  << event.center_world.transpose();
  }
}

TEST_F(EvidenceMapperTest, ADriveThatGoesOnKeepsItsOffset) {
  const Scene scene = {FarWall(), Goods(-0.7), Goods(0.7)};
  MapConfig config = PocdConfig();
  config.parameters = {{"max_session_s", 4.0}};
  MapStory story(config);
  story.Play(TakenBy(kOne, LookAtScene(scene, 0, kFrames)));
  story.EndSession(kOne);
  const std::vector<Frame> drive =
      WithOffset({-0.05, 0.0, 0.0}, LookAtScene(scene, kFrames, 2 * kFrames, 1));
  story.Play(TakenBy(kOther, {drive.begin(), drive.begin() + kFrames}));
  const std::optional<PoseErrorEstimate> first = story.map().robots.at(kOther).pose_error;
  ASSERT_TRUE(first.has_value());
  EXPECT_NEAR(first->Combined().mean.x(), 0.05, 0.015);
  // The rest of the drive shows nothing.
  std::vector<Frame> away = {drive.begin() + kFrames, drive.end()};
  for (Frame& frame : away) {
    const Image<std::uint16_t>& seen = frame.depth.units;
    frame.depth.units = Image<std::uint16_t>(seen.width_px(), seen.height_px(), kNoDepth);
  }
  story.Play(TakenBy(kOther, away));
  const std::optional<PoseErrorEstimate> kept = story.map().robots.at(kOther).pose_error;
  ASSERT_TRUE(kept.has_value());
  EXPECT_NEAR(kept->Combined().mean.x(), 0.05, 0.015);
  EXPECT_EQ(kept->time, drive.back().capture_time);
}

TEST_F(EvidenceMapperTest, TheEndOfASessionLeavesWhatOtherRobotsHaveSeen) {
  const std::vector<Frame> looks = TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames));
  const auto middle = looks.begin() + kFrames / 2;
  story_.Play({looks.begin(), middle});
  story_.Play(TakenBy(kOther, LookAtScene({FarWall()}, 0, kFrames / 2)));
  story_.EndSession(kOther);
  EXPECT_TRUE(story_.EventsOf(EventType::kCreated, kGoodsClass).empty());
  story_.Play({middle, looks.end()});
  story_.EndSession(kOne);
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, KnownObjectsAreJudgedByTheLooksOfTheSessionAlone) {
  Visit({FarWall(), Goods(0.0)});
  // What one robot saw in place before is gone when the other one looks.
  story_.Play(TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 20, kFrames, 1)));
  story_.Play(TakenBy(kOther, LookAtScene({FarWall()}, 40, kFrames, 2)));
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).front()->looks.size(), 2U);
  story_.EndSession(kOther);
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  EXPECT_TRUE(story_.Present(kGoodsClass).empty());
  // The first robot saw it before it was removed.
  const std::size_t told = story_.events().size();
  story_.EndSession(kOne);
  EXPECT_EQ(story_.events().size(), told);
  EXPECT_TRUE(story_.Present(kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, WhatWasSeenSinceIsNotRemovedByOlderLooks) {
  Visit({FarWall(), Goods(0.0)});
  story_.Play(TakenBy(kOne, LookAtScene({FarWall()}, 20, kFrames, 1)));
  story_.Play(TakenBy(kOther, LookAtScene({FarWall(), Goods(0.0)}, 40, kFrames, 2)));
  story_.EndSession(kOther);
  story_.EndSession(kOne);
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
  EXPECT_TRUE(story_.Present(kGoodsClass).front()->looks.empty());
  EXPECT_TRUE(story_.Present(kGoodsClass).front()->evidence.leaves.empty());
}

TEST_F(EvidenceMapperTest, WhatWasSeenAfterItWasFoundGoneIsBack) {
  Visit({FarWall(), Goods(0.0)});
  story_.Play(TakenBy(kOther, LookAtScene({FarWall()}, 20, kFrames, 1)));
  story_.Play(TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 40, kFrames, 2)));
  // The clock of a robot elsewhere does not date what the others see.
  story_.Play(TakenBy({"third", SensorName::kDefaultSensor},
                      WithOffset({0.0, 0.0, 50.0}, LookAtScene({FarWall()}, 60, 1, 9))));
  story_.EndSession(kOther);
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  story_.EndSession(kOne);
  EXPECT_EQ(story_.EventsOf(EventType::kReturned, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, ADriveOfThePastRemovesNothingThatWasSeenSince) {
  story_.Play(LookAtScene({FarWall(), Goods(0.0)}, 20, kFrames, 1));
  story_.EndSession();
  story_.Play(TakenBy(kOther, LookAtScene({FarWall()}, 0, kFrames)));
  story_.EndSession(kOther);
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, ADriveOfThePastMovesNothingBack) {
  for (const auto& [place, depth_m] :
       {std::pair(0.4, 1.6), std::pair(0.8, 1.6), std::pair(0.1, 1.9)}) {
    SCOPED_TRACE(place);
    MapStory story{PocdConfig()};
    story.Play(TakenBy(kOne, LookAtScene({FarWall(), Goods(place, depth_m)}, 20, kFrames, 1)));
    story.EndSession(kOne);
    // Nor does a second one: an older look is no contradiction.
    for (const int first_frame : {0, 20}) {
      story.Play(TakenBy(kOther, LookAtScene({FarWall(), Goods(0.0)}, first_frame, kFrames)));
      story.EndSession(kOther);
    }
    EXPECT_TRUE(story.EventsOf(EventType::kContradicted, kGoodsClass).empty());
    EXPECT_TRUE(story.EventsOf(EventType::kMoved, kGoodsClass).empty());
    EXPECT_EQ(story.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
    ASSERT_EQ(story.Present(kGoodsClass).size(), 1U);
    EXPECT_NEAR(story.Present(kGoodsClass).front()->cuboid.center_world.y(), place, 0.05);
  }
}

TEST_F(EvidenceMapperTest, ADriveOfThePastAddsNothingWhereALaterOneSawFreeSpace) {
  story_.Play(LookAtScene({FarWall()}, 20, kFrames, 1));
  story_.EndSession();
  story_.Play(TakenBy(kOther, LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames)));
  story_.EndSession(kOther);
  EXPECT_TRUE(story_.EventsOf(EventType::kCreated, kGoodsClass).empty());
  EXPECT_TRUE(story_.Present(kGoodsClass).empty());
  // It has come since.
  story_.Play(TakenBy(kOther, LookAtScene({FarWall(), Goods(0.0)}, 40, kFrames, 2)));
  story_.EndSession(kOther);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, ADriveOfThePastAddsAThingWhereAnEarlierOneSawFreeSpace) {
  const SceneBody screen = Body(kWallClass, {1.0, -0.1, -3.0}, {1.1, 4.0, 3.0});
  story_.Play(LookAtScene({FarWall(), Goods(-0.6)}, 0, kFrames));
  story_.EndSession();
  // A later drive sees the other goods again, and not the place of the new ones.
  story_.Play(LookAtScene({FarWall(), Goods(-0.6), screen}, 0, kFrames, 2));
  story_.EndSession();
  story_.Play(TakenBy(kOther, LookAtScene({FarWall(), Goods(-0.6), Goods(0.6)}, 0, kFrames, 1)));
  story_.EndSession(kOther);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 2U);
}

TEST_F(EvidenceMapperTest, ADriveOfThePastAddsNothingToAThingThatHasBecomeSmaller) {
  const SceneBody whole = Goods(0.0);
  SceneBody half = whole;
  half.box_world.max().z() = 0.0;
  story_.Play(LookAtScene({FarWall(), half}, 20, kFrames, 1));
  story_.EndSession();
  story_.Play(TakenBy(kOther, LookAtScene({FarWall(), whole}, 0, kFrames)));
  story_.EndSession(kOther);
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
  const Cuboid& cuboid = story_.Present(kGoodsClass).front()->cuboid;
  EXPECT_LT(cuboid.center_world.z() + 0.5 * cuboid.size_m.z(), 0.1);
}

TEST_F(EvidenceMapperTest, ARobotWhoseClockIsAheadEndsNoOtherSession) {
  story_.Play(TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames)));
  story_.Play(TakenBy(kOther, LookAtScene({FarWall(), Goods(0.0)}, kFrames, kFrames, 10)));
  story_.EndSession(kOther);
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_NE(story_.map().robots.at(kOne).session_start, std::nullopt);
  story_.EndSession(kOne);
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, AThingThatTwoRobotsSeeAtOnceIsOneObject) {
  for (const Frame& look : LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames)) {
    story_.Play(TakenBy(kOne, {look}));
    story_.Play(TakenBy(kOther, {look}));
  }
  for (const SensorName& sensor : {kOne, kOther}) {
    story_.EndSession(sensor);
    EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
    EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
  }
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, ARobotThatAlwaysFindsGoneWhatAnotherOneSeesContradictsIt) {
  for (int round = 0; round < 4; ++round) {
    VisitBy(kOne, {FarWall(), Goods(0.0)});
    VisitBy(kOther, {FarWall()});
    story_.Restart();
  }
  // The first time, it may have been taken away and put back.
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.EventsOf(EventType::kReturned, kGoodsClass).size(), 1U);
  const std::vector<ObjectEvent> contradicted =
      story_.EventsOf(EventType::kContradicted, kGoodsClass);
  ASSERT_EQ(contradicted.size(), 1U);
  EXPECT_EQ(contradicted[0].reason, EventReason::kDisagreement);
  EXPECT_EQ(contradicted[0].source, kOther);
  EXPECT_FALSE(contradicted[0].IsOfRobot());
  EXPECT_LT(contradicted[0].after.stationarity(), contradicted[0].before.stationarity());
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
  const MapObject& goods = *story_.Present(kGoodsClass)[0];
  ASSERT_EQ(goods.contradictions.size(), 1U);
  EXPECT_EQ(goods.contradictions[0].absent, kOther);
  EXPECT_EQ(goods.contradictions[0].present, kOne);
  EXPECT_EQ(goods.contradictions[0].sessions, 4U);
}

TEST_F(EvidenceMapperTest, AContradictionEndsWhenBothRobotsAgree) {
  for (const bool is_there : {true, false}) {
    SCOPED_TRACE(is_there);
    for (int round = 0; round < 3; ++round) {
      VisitBy(kOne, {FarWall(), Goods(0.0)});
      VisitBy(kOther, {FarWall()});
    }
    ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
    if (is_there) {
      VisitBy(kOther, {FarWall(), Goods(0.0)});
      ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
      EXPECT_TRUE(story_.Present(kGoodsClass)[0]->contradictions.empty());
    } else {
      VisitBy(kOne, {FarWall()});
      EXPECT_TRUE(story_.Present(kGoodsClass).empty());
    }
  }
}

TEST_F(EvidenceMapperTest, RobotsThatSeeAThingInTwoPlacesStopMovingIt) {
  std::size_t told = 0;
  for (int round = 0; round < 6; ++round) {
    VisitBy(kOne, {FarWall(), Goods(-0.4)});
    VisitBy(kOther, {FarWall(), Goods(0.4)});
    if (round == 3) told = story_.events().size();
  }
  EXPECT_EQ(story_.events().size(), told);
  EXPECT_EQ(story_.EventsOf(EventType::kMoved, kGoodsClass).size(), 2U);
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 2U);
  for (const auto& goods : story_.Present(kGoodsClass)) {
    EXPECT_EQ(goods->contradictions.size(), 1U);
  }
}

TEST_F(EvidenceMapperTest, RobotsThatSeeAThingBesideItsPlaceStopPushingIt) {
  std::size_t told = 0;
  for (int round = 0; round < 6; ++round) {
    VisitBy(kOne, {FarWall(), Goods(-0.2)});
    VisitBy(kOther, {FarWall(), Goods(0.2)});
    if (round == 3) told = story_.events().size();
  }
  EXPECT_EQ(story_.events().size(), told);
  EXPECT_EQ(story_.EventsOf(EventType::kMoved, kGoodsClass).size(), 2U);
  EXPECT_FALSE(story_.EventsOf(EventType::kContradicted, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, RobotsThatContradictEachOtherAtOnceBothKeepWhatTheySee) {
  // The session of one ends so much earlier, and is decided later.
  constexpr Duration kBehind = Duration::FromSeconds(0.05);
  for (int round = 0; round < 6; ++round) {
    const auto looks = [&](double y) {
      return LookAtScene({FarWall(), Goods(y)}, 0, kFrames, round);
    };
    const std::vector<Frame> ones = TakenBy(kOne, looks(-0.4));
    std::vector<Frame> others = TakenBy(kOther, looks(0.4));
    for (Frame& frame : others) frame.capture_time = frame.capture_time - kBehind;
    for (std::size_t i = 0; i < ones.size(); ++i) story_.Play({ones[i], others[i]});
    story_.EndSession(kOne);
    story_.EndSession(kOther);
  }
  EXPECT_FALSE(story_.EventsOf(EventType::kContradicted, kGoodsClass).empty());
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 2U);
}

TEST_F(EvidenceMapperTest, EventsAreDatedByTheFramesOfTheirOwnSession) {
  const std::vector<Frame> frames = TakenBy(kOne, LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames));
  story_.Play(frames);
  // A clock that is an hour ahead, of a robot elsewhere.
  story_.Play(
      TakenBy(kOther, WithOffset({0.0, 0.0, 50.0}, LookAtScene({FarWall()}, kFrames, 1, 60))));
  story_.EndSession(kOne);
  const std::vector<ObjectEvent> created = story_.EventsOf(EventType::kCreated, kGoodsClass);
  ASSERT_EQ(created.size(), 1U);
  EXPECT_EQ(created[0].time, frames.back().capture_time);
  EXPECT_GT(story_.map().last_capture_time, frames.back().capture_time);
}

TEST_F(EvidenceMapperTest, AnotherVisitToAnUnchangedPlaceTellsNothing) {
  Visit({FarWall(), Goods(0.0)});
  const std::size_t told = story_.events().size();
  Visit({FarWall(), Goods(0.0)});
  EXPECT_EQ(story_.events().size(), told);
}

TEST_F(EvidenceMapperTest, WhatIsSeenThroughIsRemoved) {
  Visit({FarWall(), Goods(0.0)});
  Visit({FarWall()});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  EXPECT_TRUE(story_.Present(kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, AThingInAnotherPlaceHasMoved) {
  Visit({FarWall(), Goods(-0.4)});
  Visit({FarWall(), Goods(0.4)});
  EXPECT_EQ(story_.EventsOf(EventType::kMoved, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, AMovedThingKeepsItsIdentityAndItsShape) {
  Visit({FarWall(), Goods(-0.4)});
  const MapObject before = *story_.Present(kGoodsClass).front();
  const std::size_t surface_before = CountSurfaceIn(story_.map(), Around(Goods(-0.4), 0.1));
  Visit({FarWall(), Goods(0.4)});
  const std::vector<ObjectEvent> moved = story_.EventsOf(EventType::kMoved, kGoodsClass);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].object, before.id);
  ASSERT_TRUE(moved[0].old_center_world.has_value());
  EXPECT_NEAR(moved[0].old_center_world->y(), -0.4, 0.1);
  EXPECT_NEAR(moved[0].center_world.y(), 0.4, 0.1);
  const MapObject& after = *story_.Present(kGoodsClass).front();
  EXPECT_EQ(after.id, before.id);
  EXPECT_EQ(after.first_seen, before.first_seen);
  // Of the surface known before, what resampling keeps: it loses sides that were only seen at flat
  // angles, since not all eight voxels around their points are observed.
  EXPECT_GT(CountSurfaceIn(story_.map(), Around(Goods(0.4), 0.1)), 9 * surface_before / 10);
  EXPECT_FALSE(story_.map().objects.contains(moved[0].related));
}

TEST_F(EvidenceMapperTest, ARemovedThingThatComesBackReturns) {
  Visit({FarWall(), Goods(0.0)});
  const MapObject before = *story_.Present(kGoodsClass).front();
  Visit({FarWall()});
  EXPECT_EQ(CountSurfaceIn(story_.map(), Around(Goods(0.0), 0.1)), 0U);
  Visit({FarWall(), Goods(0.0)});
  const std::vector<ObjectEvent> returned = story_.EventsOf(EventType::kReturned, kGoodsClass);
  ASSERT_EQ(returned.size(), 1U);
  EXPECT_EQ(returned[0].object, before.id);
  EXPECT_EQ(story_.Present(kGoodsClass).front()->first_seen, before.first_seen);
}

TEST_F(EvidenceMapperTest, AHiddenThingStays) {
  Visit({FarWall(), Goods(0.0)});
  Visit({FarWall(), Goods(0.0), Body(kWallClass, {0.9, -2.0, -2.0}, {1.1, 2.0, 2.0})});
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, NothingOfAPersonIsKept) {
  const SceneBody person = Body(kPersonClass, {1.2, -0.2, -0.7}, {1.5, 0.2, 0.7});
  Visit({FarWall(), person});
  EXPECT_EQ(CountSurfaceIn(story_.map(), Around(person, 0.2)), 0U);
  EXPECT_TRUE(story_.Present(kPersonClass).empty());
}

TEST_F(EvidenceMapperTest, AThingOfAFewCentimetresIsAnObjectInAFineMap) {
  MapConfig config = PocdConfig();
  config.voxel_size_m = 0.02;
  config.truncation_m = 0.06;
  MapStory fine(config);
  fine.Look({FarWall(), Body(kGoodsClass, {1.3, -0.06, -0.06}, {1.42, 0.06, 0.06})}, kFrames);
  fine.EndSession();
  EXPECT_EQ(fine.Present(kGoodsClass).size(), 1U);
}

/// Returns frames of goods that appear rotated in place by `yaw_rad`: the camera poses are rotated
/// about the centre of the goods.
std::vector<Frame> LookAtTurned(const SceneBody& goods, double yaw_rad, int first, int visit) {
  const Eigen::Vector3d center_world = goods.box_world.center();
  const Eigen::Isometry3d turn = Eigen::Translation3d(center_world) *
                                 Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                                 Eigen::Translation3d(-center_world);
  std::vector<Frame> frames = LookAtScene({goods}, first, kFrames, visit);
  for (Frame& frame : frames) frame.T_world_camera = turn * frame.T_world_camera;
  return frames;
}

TEST_F(EvidenceMapperTest, ALittleTurnIsPoseError) {
  Visit({Goods(0.0)});
  story_.Play(LookAtTurned(Goods(0.0), 0.02, kFrames + 1, 1));
  story_.EndSession();
  EXPECT_EQ(story_.events().size(), 1U);
}

TEST_F(EvidenceMapperTest, ThePartOfAPileThatWasTakenAwayIsRemoved) {
  const auto pile = [](double top_m) {
    return Body(kGoodsClass, {1.6, -0.4, -0.8}, {2.0, 0.4, top_m});
  };
  Visit({FarWall(), pile(0.6)});
  const ObjectId id = story_.Present(kGoodsClass).front()->id;
  Visit({FarWall(), pile(0.2)});
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).front()->id, id);
  EXPECT_NEAR(story_.Present(kGoodsClass).front()->cuboid.highest_m(), 0.2, 0.15);
  const std::vector<ObjectEvent> removed = story_.EventsOf(EventType::kRemoved, kGoodsClass);
  ASSERT_EQ(removed.size(), 1U);
  EXPECT_EQ(removed.front().related, id);
  EXPECT_GT(removed.front().center_world.z(), 0.2);
}

TEST_F(EvidenceMapperTest, TwinsAreNotGuessed) {
  Visit({FarWall(), Goods(-0.8), Goods(0.0)});
  Visit({FarWall()});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 2U);
  Visit({FarWall(), Goods(0.8)});
  EXPECT_TRUE(story_.EventsOf(EventType::kMoved, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, NeighboursOfOneClassAreTwoAndOneMayLeave) {
  Visit({FarWall(), Goods(-0.35), Goods(0.35)});
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 2U);
  Visit({FarWall(), Goods(-0.35)});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

/// Returns a post 10 cm wide that stands at `y`.
SceneBody Post(double y, double lowest_m, double highest_m) {
  return Body(kGoodsClass, {1.6, y - 0.05, lowest_m}, {1.7, y + 0.05, highest_m});
}

TEST_F(EvidenceMapperTest, LegsOfWhatIsAboveTheViewAreOneThing) {
  Visit({FarWall(), Post(-0.3, -0.5, 3.0), Post(0.5, -0.5, 3.0)});
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  const auto things = story_.Present(kGoodsClass);
  ASSERT_EQ(things.size(), 1U);
  EXPECT_GT(things.front()->cuboid.size_m.maxCoeff(), 0.8);
}

TEST_F(EvidenceMapperTest, PostsThatAreSeenFromEndToEndAreTwoThings) {
  Visit({FarWall(), Post(-0.3, -0.5, 0.4), Post(0.5, -0.5, 0.4)});
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 2U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 2U);
}

TEST_F(EvidenceMapperTest, APostOnAThingIsSeenFromEndToEnd) {
  const SceneBody table = Body(kTableClass, {1.4, -1.0, -0.6}, {2.0, 1.2, -0.5});
  Visit({FarWall(), table, Post(-0.3, -0.5, 0.4), Post(0.5, -0.5, 0.4)});
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 2U);
}

TEST_F(EvidenceMapperTest, LegsThatAreFarApartAreTwoThings) {
  const SceneBody near = Post(-0.3, -0.5, 0.1);
  const SceneBody hides_tops = Body(kWallClass, {1.2, -4.0, -0.05}, {1.3, 4.0, 0.4});
  Visit({FarWall(), hides_tops, near, Post(1.0, -0.5, 0.1)});
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 2U);
}

TEST_F(EvidenceMapperTest, ALegBesideAKnownOneIsAPartOfIt) {
  const SceneBody hides_one = Body(kWallClass, {1.2, 0.2, -3.0}, {1.3, 1.0, 3.0});
  Visit({FarWall(), hides_one, Post(-0.3, -0.5, 3.0), Post(0.5, -0.5, 3.0)});
  ASSERT_EQ(story_.Present(kGoodsClass).size(), 1U);
  Visit({FarWall(), Post(-0.3, -0.5, 3.0), Post(0.5, -0.5, 3.0)});
  EXPECT_EQ(story_.EventsOf(EventType::kCreated, kGoodsClass).size(), 1U);
  EXPECT_EQ(story_.Present(kGoodsClass).size(), 1U);
}

TEST_F(EvidenceMapperTest, TwoFramesWithAWrongLabelDoNotMakeAThingBackground) {
  std::vector<Frame> frames = testing::LookAtScene({FarWall(), Goods(0.0)}, 0, kFrames);
  for (std::size_t i = 0; i < 2; ++i) {
    Image<std::uint16_t>& labels = frames[i].labels;
    std::replace(labels.data(), labels.data() + labels.size(), kGoodsClass, kFloorClass);
  }
  story_.Play(frames);
  story_.EndSession();
  const auto things = story_.Present(kGoodsClass);
  ASSERT_EQ(things.size(), 1U);
  EXPECT_GT(things.front()->cuboid.size_m.maxCoeff(), 0.55);
}

TEST_F(EvidenceMapperTest, ASideAtAFlatAngleBelongsToItsThing) {
  Visit({FarWall(), Body(kGoodsClass, {1.2, 0.55, -0.3}, {2.2, 1.0, 0.3})});
  const auto things = story_.Present(kGoodsClass);
  ASSERT_EQ(things.size(), 1U);
  EXPECT_GT(things.front()->cuboid.size_m.x(), 0.8);
}

TEST_F(EvidenceMapperTest, FlatAnglesDoNotConnectNeighbours) {
  // In one line, so that the tops of both are one surface for a camera that looks along them.
  Visit({FarWall(),
         Body(kGoodsClass, {1.0, 0.1, -0.6}, {1.4, 0.6, -0.2}),
         Body(kGoodsClass, {1.5, 0.1, -0.6}, {1.9, 0.6, -0.2})});
  for (const auto& thing : story_.Present(kGoodsClass)) {
    EXPECT_LT(thing->cuboid.size_m.x(), 0.6);
  }
}

/// Returns two things that touch, in one line, so that their sides and tops are one surface for a
/// camera that looks along them.
Scene TwoInLine() {
  return {FarWall(),
          Body(kGoodsClass, {1.0, 0.3, -0.6}, {1.5, 0.7, -0.1}),
          Body(kGoodsClass, {1.5, 0.3, -0.6}, {2.0, 0.7, -0.1})};
}

/// Returns frames of `TwoInLine` in which each thing has its own instance.
std::vector<Frame> LookAtInstances() {
  std::vector<Frame> frames = LookAtScene(TwoInLine(), 0, 3 * kFrames);
  for (Frame& frame : frames) {
    frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
    for (int v = 0; v < frame.camera.height_px; ++v) {
      for (int u = 0; u < frame.camera.width_px; ++u) {
        if (frame.labels.At(u, v) != kGoodsClass) continue;
        const double depth_m = frame.depth.units.At(u, v) * frame.depth.metres_per_unit;
        const Eigen::Vector3d point_world =
            frame.T_world_camera * (frame.camera.Ray(u, v) * depth_m);
        frame.instances.At(u, v) = point_world.x() < 1.5 ? 1 : 2;
      }
    }
  }
  return frames;
}

TEST_F(EvidenceMapperTest, ThingsOfTwoInstancesThatTouchDoNotGrowIntoEachOther) {
  story_.Play(LookAtInstances());
  story_.EndSession();
  const auto things = story_.Present(kGoodsClass);
  ASSERT_EQ(things.size(), 2U);
  for (const auto& thing : things) EXPECT_LT(thing->cuboid.size_m.x(), 0.6);
}

/// Returns the votes on all pairs of goods of a session together.
PartVotes VotesOnGoods(const MapSnapshot& map) {
  PartVotes sum;
  for (const auto& [id, object] : map.objects) {
    for (const PartVotes& votes : object->parts) {
      const auto other = map.objects.find(votes.other);
      if (object->class_id != ClassId(kGoodsClass) || other == map.objects.end() ||
          other->second->class_id != ClassId(kGoodsClass)) {
        continue;
      }
      sum.connected += votes.connected;
      sum.apart += votes.apart;
      sum.occluded += votes.occluded;
    }
  }
  return sum;
}

TEST_F(EvidenceMapperTest, AThingInFrontOfAnotherOneShowsNoGap) {
  story_.Look({FarWall(),
               Body(kGoodsClass, {1.2, -0.3, -0.6}, {1.5, 0.3, -0.2}),
               Body(kGoodsClass, {1.6, -0.3, -0.6}, {1.9, 0.3, 0.3})},
              kFrames);
  EXPECT_GT(VotesOnGoods(story_.map()).occluded, 3U);
  EXPECT_EQ(VotesOnGoods(story_.map()).apart, 0U);
}

TEST_F(EvidenceMapperTest, InstancesWithoutLabelsTellWhatIsOneThing) {
  std::vector<Frame> frames = LookAtInstances();
  for (Frame& frame : frames) frame.labels = {};
  story_.Play(frames);
  story_.EndSession();
  const auto things = story_.Present(kNoClass.value());
  ASSERT_EQ(things.size(), 2U);
  for (const auto& thing : things) {
    EXPECT_TRUE(thing->has_given_extent);
    EXPECT_LT(thing->cuboid.size_m.x(), 0.6);
    EXPECT_LT(thing->cuboid.size_m.z(), 0.6) << "without the wall behind";
  }
}

TEST_F(EvidenceMapperTest, AFrameOfInstancesDoesNotDoubtALabelledThing) {
  Visit(TwoInLine());
  std::vector<Frame> frames = LookAtInstances();
  for (Frame& frame : frames) {
    frame.labels = {};
    frame.capture_time = frame.capture_time + Duration::FromSeconds(3600.0);
  }
  story_.Play(frames);
  story_.EndSession();
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, WithoutLabelsAThingComesAndGoes) {
  VisitWithoutLabels({FarWall(), Goods(0.0)});
  ASSERT_EQ(story_.EventsOf(EventType::kCreated, kNoClass.value()).size(), 1U);
  EXPECT_EQ(story_.Present(kNoClass.value()).size(), 1U);
  VisitWithoutLabels({FarWall(), Goods(0.0)});
  EXPECT_EQ(story_.events().size(), 1U);
  VisitWithoutLabels({FarWall()});
  EXPECT_EQ(story_.EventsOf(EventType::kRemoved, kNoClass.value()).size(), 1U);
  EXPECT_TRUE(story_.Present(kNoClass.value()).empty());
}

TEST_F(EvidenceMapperTest, AFrameWithoutLabelsDoesNotDoubtALabelledThing) {
  Visit({FarWall(), Goods(0.0)});
  VisitWithoutLabels({FarWall(), Goods(0.0)});
  EXPECT_TRUE(story_.EventsOf(EventType::kRemoved, kGoodsClass).empty());
}

TEST_F(EvidenceMapperTest, ARestartInTheMiddleOfASessionChangesNothing) {
  MapStory restarted(PocdConfig());
  // The side of the second thing is at a flat angle and waits for the end of the session.
  const testing::Scene scene = {
      FarWall(), Goods(0.0), Body(kGoodsClass, {1.2, 0.55, -0.3}, {2.2, 1.0, 0.3})};
  for (MapStory* story : {&story_, &restarted}) {
    story->Look(scene, kFrames / 2);
    if (story == &restarted) story->Restart();
    story->Look(scene, kFrames / 2);
    story->EndSession();
  }
  ExpectSameMap(story_.map(), restarted.map());
  EXPECT_EQ(story_.events(), restarted.events());
}

}  // namespace
}  // namespace steadymap
