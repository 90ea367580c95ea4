// A box on a floor that was seen around it.

#include "core/objects/support.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "core/working/working_map.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

constexpr double kSideM = 0.4;

class SupportTest : public ::testing::Test {
 protected:
  SupportTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds a plane through the origin, 4 m wide, to the background.
  void PutBackground(const Eigen::Vector3d& normal) {
    const Box around(Eigen::Vector3d(-2.0, -2.0, -0.3), Eigen::Vector3d(2.0, 2.0, 0.8));
    const TsdfGrid plane =
        testing::MakeVolume([&](const Eigen::Vector3d& point) { return normal.dot(point); },
                            around,
                            map_.scale(),
                            [&](const Eigen::Vector3d& point) {
                              return std::abs(normal.dot(point)) <= map_.scale().truncation_m;
                            });
    plane.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
      LeafVoxels voxels;
      CopyLeaf(leaf, &voxels);
      map_.StoreBackgroundLeaf(origin, voxels);
    });
  }

  /// Returns a box of which the bottom is at a height, metres.
  TrackedObject* PutBox(double bottom_m) {
    const Eigen::Vector3d low(-0.5 * kSideM, -0.5 * kSideM, bottom_m);
    TrackedObject& object = map_.AddObject(low);
    const Eigen::Vector3d low_object = low - object.state().T_world_object.position_world;
    ObjectEdit edit = map_.Edit(&object);
    testing::StoreVolume(
        testing::MakeVolume({Box(low_object, low_object + Eigen::Vector3d::Constant(kSideM))},
                            map_.scale()),
        &edit);
    return &object;
  }

  bool Stands(double bottom_m) {
    return StandsOnBackground(*PutBox(bottom_m), SessionPartParameters(), map_);
  }

  WorkingMap map_{MapConfig()};
};

TEST_F(SupportTest, AThingStandsOnTheFloorThatWasSeenBesideIt) {
  EXPECT_FALSE(Stands(0.0)) << "nothing is known of the floor";
  PutBackground(Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(Stands(0.0));
  EXPECT_TRUE(Stands(0.05)) << "within the errors of a voxel";
}

TEST_F(SupportTest, TheBottomOfAThingSeenInItsUpperPartIsNotKnown) {
  PutBackground(Eigen::Vector3d::UnitZ());
  EXPECT_FALSE(Stands(0.3));
}

TEST_F(SupportTest, AWallBearsNothing) {
  PutBackground(Eigen::Vector3d::UnitX());
  EXPECT_FALSE(Stands(0.0));
}

}  // namespace
}  // namespace steadymap
