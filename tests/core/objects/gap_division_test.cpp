// Two boxes of one class with their fronts in the plane y = 0 and a gap at x = 0.

#include "core/objects/gap_division.h"

#include <gtest/gtest.h>

#include "core/association/gaps.h"
#include "core/objects/gap_planes.h"
#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::StoreVolume;

constexpr double kBoxHeightM = 0.5;

class GapDivisionTest : public ::testing::Test {
 protected:
  GapDivisionTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  TrackedObject* Put(double low_x_m, double high_x_m, ClassId class_id = ClassId(7)) {
    const Eigen::Vector3d place(low_x_m, 0.0, 0.0);
    TrackedObject& object = map_.AddObject(place);
    const Eigen::Vector3d low = place - object.state().T_world_object.position_world;
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolume({Box(low, low + Eigen::Vector3d(high_x_m - low_x_m, 0.3, kBoxHeightM))},
                           map_.scale()),
                &edit);
    edit.state().class_id = class_id;
    edit.state().supporting_frames = 10;
    return &object;
  }

  /// Adds what frames see that look along the gap from the front and from behind.
  void LookThrough(TrackedObject* object) {
    const double voxel_m = map_.scale().voxel_size_m;
    for (int frame = 0; frame < 4; ++frame) {
      std::vector<GapInView> gaps;
      for (int row = 0; row < 25; ++row) {
        GapInView gap;
        gap.middle_world = {0.0, frame % 2 == 0 ? 0.0 : 0.3, row * 0.02};
        gap.view_world = Eigen::Vector2d(0.0, frame % 2 == 0 ? 1.0 : -1.0);
        gap.width_m = 0.04;
        gap.max_angle_rad = 0.04;
        gaps.push_back(gap);
      }
      ObjectEdit edit = map_.Edit(object);
      AddGaps(gaps, voxel_m, &edit.state().gaps);
    }
  }

  PartDecisions Divide() { return DivideAtGaps(SessionPartParameters(), {}, &map_); }

  WorkingMap map_{MapConfig()};
};

TEST_F(GapDivisionTest, AnObjectAcrossAGapBecomesTwoThatAreApart) {
  TrackedObject* whole = Put(-0.5, 0.5);
  LookThrough(whole);
  const PartDecisions decisions = Divide();
  const std::vector<TrackedObject*> objects = map_.TentativeObjects();
  ASSERT_EQ(objects.size(), 2U);
  const PartDecisions expected = {{PairOf(objects[0]->id(), objects[1]->id()), false}};
  EXPECT_EQ(decisions, expected);
  for (const TrackedObject* object : objects) {
    const Box bounds = object->BoundsInWorld();
    EXPECT_TRUE(bounds.max().x() < 0.06 || bounds.min().x() > -0.06);
    EXPECT_NEAR(bounds.sizes().x(), 0.5, 0.1);
  }
  // The gap is not counted twice if the pieces are divided again.
  EXPECT_EQ(Divide(), expected);
}

TEST_F(GapDivisionTest, ObjectsOfAnotherClassAreNotDivided) {
  TrackedObject* whole = Put(-0.5, 0.5);
  LookThrough(whole);
  Put(-0.5, 0.5, ClassId(8));
  Divide();
  EXPECT_EQ(map_.TentativeObjects().size(), 3U);
}

TEST_F(GapDivisionTest, APieceOfOneBoxIsOfItWhateverTheVotesOnBothAre) {
  TrackedObject* both = Put(-0.5, 0.5);
  LookThrough(both);
  // Each frame that shows the left box gives `both` to the right one.
  TrackedObject* left = Put(-0.52, -0.3);
  for (int frame = 0; frame < 50; ++frame) VoteOnParts(PartVote::kApart, both, left, &map_);
  const PartElection election(map_.TentativeObjects(), Divide(), 0.2);
  ASSERT_EQ(map_.TentativeObjects().size(), 3U);
  for (const TrackedObject* object : map_.TentativeObjects()) {
    if (object == left) continue;
    const bool is_left = object->BoundsInWorld().center().x() < 0.0;
    EXPECT_EQ(election.AreApart(object->id(), left->id()), !is_left);
    if (!is_left) continue;
    EXPECT_EQ(election.FindPair(), PairOf(object->id(), left->id()));
  }
}

TEST_F(GapDivisionTest, SurfaceBehindAGapConnectsBothSides) {
  TrackedObject* whole = Put(-0.5, 0.5);
  LookThrough(whole);
  // A shelf of the same class over both.
  {
    ObjectEdit edit = map_.Edit(whole);
    const Eigen::Vector3d low = -whole->state().T_world_object.position_world;
    StoreVolume(MakeVolume({Box(low + Eigen::Vector3d(-0.5, 0.0, 0.0),
                                low + Eigen::Vector3d(0.5, 1.5, kBoxHeightM))},
                           map_.scale()),
                &edit);
  }
  EXPECT_TRUE(Divide().empty());
  EXPECT_EQ(map_.TentativeObjects().size(), 1U);
}

}  // namespace
}  // namespace steadymap
