// Piles in a row along y, identical unless a test specifies otherwise. One pile is new at its
// position.

#include "core/objects/relocation.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::Solid;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::WallVolume;

constexpr double kRecentS = 20.0;

/// Returns a pile with the centre of its front at `y_m`.
Solid PileAt(double y_m, double height_m = 0.0) {
  return {Box(Eigen::Vector3d(2.0, y_m - 0.25, height_m),
              Eigen::Vector3d(2.5, y_m + 0.25, height_m + 0.8))};
}

class FindMovesTest : public ::testing::Test {
 protected:
  FindMovesTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds a pile with the given times of first and last observation.
  TrackedObject* Put(double y_m, double came_s, double last_seen_s) {
    return Put(PileAt(y_m), came_s, last_seen_s);
  }

  /// Adds an object of any shape with the given times of first and last observation.
  TrackedObject* Put(const Solid& solid_world, double came_s, double last_seen_s) {
    TrackedObject& pile = map_.AddObject(solid_world.front().min());
    const Eigen::Vector3d origin_world = pile.state().T_world_object.position_world;
    Solid solid = solid_world;
    for (Box& box : solid) box.translate(-origin_world);
    ObjectEdit edit = map_.Edit(&pile);
    StoreVolume(MakeVolume(solid, map_.scale()), &edit);
    ObjectState& state = edit.state();
    state.status = ObjectStatus::kPresent;
    state.first_seen = Timestamp::FromSeconds(came_s);
    state.in_place_since = state.first_seen;
    state.last_seen = Timestamp::FromSeconds(last_seen_s);
    state.supporting_frames = 20;
    in_view_.push_back({&pile, 0, 10, 0, 10});
    return &pile;
  }

  /// Adds a pile that was observed long ago and is now missed.
  TrackedObject* PutMissed(double y_m) { return PutMissed(PileAt(y_m)); }

  /// Adds a pile that was archived at `given_up_s`.
  void PutGivenUp(double y_m, double given_up_s) {
    TrackedObject* pile = PutMissed(y_m);
    ObjectEdit edit = map_.Edit(pile);
    edit.state().status = ObjectStatus::kArchived;
    edit.state().in_place_since = Timestamp::FromSeconds(given_up_s);
  }

  TrackedObject* PutMissed(const Solid& solid_world) {
    TrackedObject* pile = Put(solid_world, 10.0, 30.0);
    ObjectEdit edit = map_.Edit(pile);
    edit.state().evidence.absent_streak_cells = 12.0;
    return pile;
  }

  /// Sets every cell of the surface as observed at `found_s`.
  void FindAllOf(TrackedObject* pile, double found_s) {
    ObjectEdit edit = map_.Edit(pile);
    for (const SurfaceLeaf& leaf : pile->surface().leaves()) {
      LeafEvidence& evidence = edit.state().evidence.MutableLeaf(leaf.origin);
      evidence.confirmed = Timestamp::FromSeconds(found_s);
      evidence.score.fill(1);
    }
  }

  std::vector<ObjectEvent> Find() {
    FindRelocations(in_view_, kRecentS, RelocationParameters(), &map_);
    map_.EndFrame();
    return map_.Commit().delta.events;
  }

  WorkingMap map_{MapConfig()};
  std::vector<ObjectInView> in_view_;
};

TEST_F(FindMovesTest, TellsAPileThatWasPushedAside) {
  const ObjectId missed = PutMissed(0.0)->id();
  const ObjectId found = Put(0.7, 95.0, 100.0)->id();
  const std::vector<ObjectEvent> events = Find();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kMoved);
  EXPECT_EQ(events[0].object, missed);
  EXPECT_EQ(events[0].related, found);
  EXPECT_NEAR(events[0].old_center_world.value().y(), 0.0, 0.05);
  EXPECT_NEAR(events[0].center_world.y(), 0.7, 0.05);
}

TEST_F(FindMovesTest, TellsAMoveOfWhatHadShownItsFrontAlone) {
  const Eigen::Vector3d middle(2.0, 0.0, 0.5);
  TrackedObject* front = PutMissed({Box(middle, middle)});
  {
    ObjectEdit edit = map_.Edit(front);
    StoreVolume(WallVolume(0.0, map_.scale()), &edit);
  }
  ASSERT_LT(front->cuboid().size_m.y(), 0.05);
  const ObjectId missed = front->id();
  // The sides of this box are outside the observed voxels of the front.
  Put({Box(Eigen::Vector3d(1.4, -0.56, -0.06), Eigen::Vector3d(1.58, 0.56, 1.06))}, 95.0, 100.0);
  const std::vector<ObjectEvent> events = Find();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, EventType::kMoved);
  EXPECT_EQ(events[0].object, missed);
}

TEST_F(FindMovesTest, TellsNoMoveOntoAnotherBoard) {
  PutMissed(0.0);
  Put(PileAt(0.3, 0.5), 95.0, 100.0);
  EXPECT_TRUE(Find().empty());
}

TEST_F(FindMovesTest, TellsNoMoveOfASmallThingThatBecameAThirdLonger) {
  PutMissed({Box(Eigen::Vector3d(2.0, 0.0, 0.0), Eigen::Vector3d(2.3, 0.3, 0.3))});
  Put({Box(Eigen::Vector3d(2.0, 0.6, 0.0), Eigen::Vector3d(2.3, 1.05, 0.3))}, 95.0, 100.0);
  EXPECT_TRUE(Find().empty());
}

TEST_F(FindMovesTest, TellsNoMoveOfWhatHasAnotherShape) {
  PutMissed(0.0);
  const Solid step = {Box(Eigen::Vector3d(2.0, 0.45, 0.0), Eigen::Vector3d(2.5, 0.95, 0.35)),
                      Box(Eigen::Vector3d(2.0, 0.45, 0.0), Eigen::Vector3d(2.2, 0.95, 0.8))};
  Put(step, 95.0, 100.0);
  EXPECT_TRUE(Find().empty());
}

TEST_F(FindMovesTest, TellsNoMoveOfWhatWasFoundAMomentAgo) {
  FindAllOf(PutMissed(0.0), 90.0);
  Put(0.7, 95.0, 100.0);
  EXPECT_TRUE(Find().empty()) << "an edge alone is missed";
}

TEST_F(FindMovesTest, TellsAMoveOfWhatWasFoundLongAgo) {
  FindAllOf(PutMissed(0.0), 70.0);
  Put(0.7, 95.0, 100.0);
  EXPECT_EQ(Find().size(), 1U);
}

TEST_F(FindMovesTest, TellsAMoveToAPlaceThatOverlapsTheOldOne) {
  FindAllOf(PutMissed(0.0), 90.0);
  Put(0.3, 95.0, 100.0);
  EXPECT_EQ(Find().size(), 1U) << "it is the new surface that was found";
}

TEST_F(FindMovesTest, NeverGuessesWhichOfTwoMissedPilesWasPushed) {
  PutMissed(0.0);
  PutMissed(1.4);
  Put(0.7, 95.0, 100.0);
  EXPECT_TRUE(Find().empty());
}

TEST_F(FindMovesTest, NeverGuessesWhetherAPileWasPushedOrOneThatWasGivenUpBefore) {
  PutMissed(0.0);
  PutGivenUp(1.4, 93.0);
  Put(0.7, 95.0, 100.0);
  EXPECT_TRUE(Find().empty());
}

TEST_F(FindMovesTest, LeavesOutANeighbourThatWentLongBefore) {
  const ObjectId missed = PutMissed(0.0)->id();
  PutGivenUp(1.4, 40.0);
  Put(0.7, 95.0, 100.0);
  const std::vector<ObjectEvent> events = Find();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].object, missed);
}

TEST_F(FindMovesTest, LeavesOutANeighbourThatStillStands) {
  const ObjectId missed = PutMissed(0.0)->id();
  Put(1.4, 10.0, 100.0);
  Put(0.7, 95.0, 100.0);
  const std::vector<ObjectEvent> events = Find();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].object, missed);
}

TEST_F(FindMovesTest, TakesTheOneThatIsClearlyNearer) {
  PutMissed(1.6);
  const ObjectId missed = PutMissed(0.4)->id();
  Put(0.7, 95.0, 100.0);
  const std::vector<ObjectEvent> events = Find();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].object, missed);
}

}  // namespace
}  // namespace steadymap
