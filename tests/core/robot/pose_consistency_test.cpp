#include "core/robot/pose_consistency.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/mapper.h"
#include "tests/core/policy/map_story.h"
#include "tests/core/policy/room_drive.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::Drive;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::LookOf;
using ::steadymap::testing::MapStory;
using ::steadymap::testing::Mislead;
using ::steadymap::testing::PocdConfig;
using ::steadymap::testing::Room;
using ::steadymap::testing::RoomWithout;
using ::steadymap::testing::Scene;

/// Share of the patches known to the map that fit it; 0 where none is known.
double FittingShare(const PoseConsistency& view) {
  if (view.fitting == 0) return 0.0;
  return static_cast<double>(view.fitting) / static_cast<double>(view.fitting + view.contradicting);
}

/// Frames compared with a map of the room.
class FrameAgreementTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    MapStory story(PocdConfig());
    story.Play(Drive(Room(), 0, 70), 70);
    room = new MapSnapshot(story.map());
  }

  static void TearDownTestSuite() {
    delete room;
    room = nullptr;
  }

  FrameAgreementTest() : map_(PocdConfig()), cloud_(PocdConfig()) { map_.Restore(*room); }

  PoseConsistency Compare(const Frame& frame, const WorkingMap& map) {
    cloud_.Compute(frame);
    samples_.Compute(cloud_);
    tiles_.Compute(frame.depth);
    return CompareFrame(
        PoseConsistencyParameters(), {cloud_, samples_, tiles_}, frame.T_world_camera, map);
  }

  PoseConsistency Compare(const Frame& frame) { return Compare(frame, map_); }

  static MapSnapshot* room;
  WorkingMap map_;
  SemanticCloud cloud_;
  SampleGrid samples_;
  MinDepthGrid tiles_;
};

MapSnapshot* FrameAgreementTest::room = nullptr;

TEST_F(FrameAgreementTest, AFrameOfTheMappedRoomFits) {
  for (const int index : {5, 15, 40}) {
    const PoseConsistency agreement = Compare(Drive(Room(), index, 1)[0]);
    EXPECT_EQ(agreement.patches, 20U * 15U);
    EXPECT_GT(agreement.fitting, 60U);
    EXPECT_GT(FittingShare(agreement), 0.9);
  }
}

TEST_F(FrameAgreementTest, ASmallErrorOfThePoseStillFits) {
  for (const int index : {5, 15, 40}) {
    for (const double sign : {-1.0, 1.0}) {
      const Frame frame = Mislead(Drive(Room(), index, 1), sign * 0.1, 0.035)[0];
      EXPECT_GT(FittingShare(Compare(frame)), 0.6) << index;
    }
  }
}

TEST_F(FrameAgreementTest, ALargeErrorOfThePoseDoesNot) {
  for (const int index : {5, 15, 40}) {
    for (const double sign : {-1.0, 1.0}) {
      const Frame frame = Mislead(Drive(Room(), index, 1), 1.0, sign * 0.7)[0];
      EXPECT_LT(FittingShare(Compare(frame)), 0.25) << index;
    }
  }
}

TEST_F(FrameAgreementTest, ComparesAsIfTheCameraStoodElsewhere) {
  const Frame frame = Drive(Room(), 15, 1)[0];
  const PoseConsistency straight = Compare(frame);
  const Frame misled = Mislead({frame}, 1.0, 0.7)[0];
  cloud_.Compute(misled);
  samples_.Compute(cloud_);
  tiles_.Compute(misled.depth);
  const PoseConsistency corrected = CompareFrame(
      PoseConsistencyParameters(), {cloud_, samples_, tiles_}, frame.T_world_camera, map_);
  EXPECT_EQ(corrected.patches, straight.patches);
  EXPECT_NEAR(FittingShare(corrected), FittingShare(straight), 0.02);
}

TEST_F(FrameAgreementTest, LookingThroughABoxThatIsGoneContradicts) {
  const PoseConsistency whole = Compare(Drive(Room(), 0, 1)[0]);
  const PoseConsistency without = Compare(Drive(RoomWithout(2), 0, 1)[0]);
  EXPECT_GT(without.contradicting, whole.contradicting + 10);
}

TEST_F(FrameAgreementTest, ANewThingWhereNothingWasContradicts) {
  Scene scene = Room();
  scene.push_back(Body(testing::kGoodsClass, {1.0, 0.2, 0.3}, {1.2, 1.0, 1.0}));
  EXPECT_GT(Compare(Drive(scene, 0, 1)[0]).contradicting, 20U);
}

TEST_F(FrameAgreementTest, APersonSaysNothing) {
  Scene scene = Room();
  scene.push_back(Body(kPersonClass, {1.0, 0.2, 0.3}, {1.2, 1.0, 1.0}));
  EXPECT_LT(Compare(Drive(scene, 0, 1)[0]).contradicting, 8U);
}

TEST_F(FrameAgreementTest, AnEmptyMapKnowsNothing) {
  const PoseConsistency agreement = Compare(Drive(Room(), 15, 1)[0], WorkingMap(PocdConfig()));
  EXPECT_EQ(agreement.fitting + agreement.contradicting, 0U);
  EXPECT_GT(agreement.unknown, 60U);
}

TEST_F(FrameAgreementTest, AFloorThatFitsCountsForNothing) {
  const Scene floor = {Room().front()};
  MapStory story(PocdConfig());
  story.Play(Drive(floor, 0, 20), 20);
  WorkingMap map(PocdConfig());
  map.Restore(story.map());
  const PoseConsistency agreement = Compare(Mislead(Drive(floor, 15, 1), 0.3, 0.7)[0], map);
  EXPECT_EQ(agreement.fitting, 0U);
  EXPECT_LT(agreement.contradicting, 3U);
}

TEST_F(FrameAgreementTest, FramesOfAnySizeAreTaken) {
  for (const auto& [width_px, height_px] :
       {std::pair{1, 1}, {2, 1}, {4, 4}, {1, 300}, {14, 12}, {16, 16}, {17, 33}}) {
    for (const double depth_m : {0.0, 0.001, 2.0, 65.5}) {
      const Frame frame = testing::SmallFrame(width_px, height_px, depth_m, 1.0);
      const PoseConsistency agreement = Compare(frame);
      EXPECT_LE(agreement.fitting + agreement.contradicting + agreement.unknown, agreement.patches);
    }
  }
}

}  // namespace
}  // namespace steadymap
