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

constexpr double kReachVoxels = 1.5;

class UnsegmentedSurfaceTest : public ::testing::Test {
 protected:
  UnsegmentedSurfaceTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds a box between `low_x_m` and `high_x_m`, 0.5 m wide and high, seen in segments of
  /// `frames` frames.
  TrackedObject* Put(double low_x_m,
                     double high_x_m,
                     std::uint64_t frames,
                     ClassId class_id = ClassId(7)) {
    const Eigen::Vector3d place(low_x_m, 0.0, 0.0);
    TrackedObject& object = map_.AddObject(place);
    const Eigen::Vector3d low = place - object.state().T_world_object.position_world;
    const Eigen::Vector3d size_m(high_x_m - low_x_m, 0.5, 0.5);
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolume({Box(low, low + size_m)}, map_.scale()), &edit);
    edit.state().class_id = class_id;
    edit.state().supporting_frames = frames;
    return &object;
  }

  TrackedObject* PutUnsegmented(double low_x_m, double high_x_m) {
    return Put(low_x_m, high_x_m, 0);
  }

  void Add() {
    AddUnsegmentedSurface(kReachVoxels, {}, &map_);
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

TEST_F(UnsegmentedSurfaceTest, OfAnotherClassIsOfNoObject) {
  const TrackedObject* object = Put(0.0, 0.5, 10, ClassId(8));
  PutUnsegmented(0.5, 1.5);
  Add();
  EXPECT_NEAR(object->cuboid().size_m.x(), 0.5, 0.05);
  EXPECT_EQ(map_.TentativeObjects().size(), 1U);
}

}  // namespace
}  // namespace steadymap
