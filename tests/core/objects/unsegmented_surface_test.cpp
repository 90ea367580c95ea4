// Boxes of a session, and surface that no segment showed.

#include "core/objects/unsegmented_surface.h"

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::StoreVolume;

// A table 0.7 m high, 1 m long, and the lower end of its leg: the top hides the upper end.
const Box kTableTop(Eigen::Vector3d(0.0, 0.0, 0.6), Eigen::Vector3d(1.0, 0.5, 0.7));
const Box kLeg(Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.05, 0.05, 0.4));

class UnsegmentedSurfaceTest : public ::testing::Test {
 protected:
  UnsegmentedSurfaceTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds a box between `low_x_m` and `high_x_m`, 0.5 m wide and high, seen in segments of
  /// `frames` frames.
  TrackedObject* Put(double low_x_m,
                     double high_x_m,
                     std::uint64_t frames,
                     ClassId class_id = ClassId(7)) {
    const Box box_world(Eigen::Vector3d(low_x_m, 0.0, 0.0), Eigen::Vector3d(high_x_m, 0.5, 0.5));
    return PutBox(box_world, frames, class_id);
  }

  TrackedObject* PutBox(const Box& box_world, std::uint64_t frames, ClassId class_id = ClassId(7)) {
    TrackedObject& object = map_.AddObject(box_world.min());
    const Eigen::Vector3d low = box_world.min() - object.state().T_world_object.position_world;
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolume({Box(low, low + box_world.sizes())}, map_.scale()), &edit);
    edit.state().class_id = class_id;
    edit.state().supporting_frames = frames;
    return &object;
  }

  TrackedObject* PutUnsegmented(double low_x_m, double high_x_m) {
    return Put(low_x_m, high_x_m, 0);
  }

  void Add() {
    AddUnsegmentedSurface(SessionPartParameters(), {}, &map_);
    for (const TrackedObject* object : map_.TentativeObjects()) {
      EXPECT_FALSE(IsUnsegmented(*object));
    }
  }

  WorkingMap map_{MapConfig()};
};

TEST_F(UnsegmentedSurfaceTest, IsWhatNoSegmentSupports) {
  EXPECT_TRUE(IsUnsegmented(*PutUnsegmented(0.0, 1.0)));
  TrackedObject* object = Put(0.0, 1.0, 1);
  EXPECT_FALSE(IsUnsegmented(*object));
  {
    ObjectEdit edit = map_.Edit(object);
    edit.state().status = ObjectStatus::kPresent;
    edit.state().supporting_frames = 0;
  }
  EXPECT_FALSE(IsUnsegmented(*object));
}

TEST_F(UnsegmentedSurfaceTest, GoesToTheObjectThatItContinues) {
  const TrackedObject* object = Put(0.0, 0.5, 10);
  PutUnsegmented(0.5, 1.5);
  Add();
  EXPECT_NEAR(object->cuboid().size_m.x(), 1.5, 0.05);
  EXPECT_EQ(map_.TentativeObjects().size(), 1U);
}

TEST_F(UnsegmentedSurfaceTest, BetweenTwoObjectsEachGetsTheNearerHalf) {
  const TrackedObject* left = Put(0.0, 0.5, 10);
  const TrackedObject* right = Put(1.5, 2.0, 10);
  PutUnsegmented(0.5, 1.5);
  Add();
  EXPECT_NEAR(left->cuboid().size_m.x(), 1.0, 0.15);
  EXPECT_NEAR(right->cuboid().size_m.x(), 1.0, 0.15);
}

TEST_F(UnsegmentedSurfaceTest, BeyondAGapIsOfNoObject) {
  const TrackedObject* object = Put(0.0, 0.5, 10);
  PutUnsegmented(0.8, 1.5);
  Add();
  EXPECT_NEAR(object->cuboid().size_m.x(), 0.5, 0.05);
  EXPECT_EQ(map_.TentativeObjects().size(), 1U);
}

TEST_F(UnsegmentedSurfaceTest, ALegOfWhichTheUpperEndIsHiddenBelongsToItsTable) {
  const TrackedObject* table = PutBox(kTableTop, 10);
  PutBox(kLeg, 0);
  Add();
  EXPECT_NEAR(table->cuboid().lowest_m(), 0.0, 0.05);
  EXPECT_EQ(map_.TentativeObjects().size(), 1U);
}

TEST_F(UnsegmentedSurfaceTest, ALegThatWasSeenFromEndToEndIsOfNoObject) {
  const TrackedObject* table = PutBox(kTableTop, 10);
  PutBox(kLeg, 0);
  for (int x = -4; x <= 4; ++x) {
    for (int y = -4; y <= 4; ++y) {
      map_.MarkFree({0.05 * x, 0.05 * y, -0.4}, {0.05 * x, 0.05 * y, 0.59}, map_.now());
    }
  }
  Add();
  EXPECT_NEAR(table->cuboid().lowest_m(), 0.6, 0.05);
}

TEST_F(UnsegmentedSurfaceTest, ALegThatLooksFindGoneWasAWrongLabel) {
  const TrackedObject* table = PutBox(kTableTop, 10);
  TrackedObject* leg = PutBox(kLeg, 0);
  {
    ObjectEdit edit = map_.Edit(leg);
    for (const SurfaceLeaf& leaf : leg->surface().leaves()) {
      edit.state().evidence.MutableLeaf(leaf.origin).score.fill(-2);
    }
  }
  Add();
  EXPECT_NEAR(table->cuboid().lowest_m(), 0.6, 0.05);
}

TEST_F(UnsegmentedSurfaceTest, OfAnotherClassIsOfNoObject) {
  const TrackedObject* object = Put(0.0, 0.5, 10, ClassId(8));
  PutUnsegmented(0.5, 1.5);
  Add();
  EXPECT_NEAR(object->cuboid().size_m.x(), 0.5, 0.05);
  EXPECT_EQ(map_.TentativeObjects().size(), 1U);
}

}  // namespace
}  // namespace steadymap
