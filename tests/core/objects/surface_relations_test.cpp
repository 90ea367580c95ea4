// A box whose surface was found, and other boxes around it.

#include "core/objects/surface_relations.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/change/surface_looks.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolume;
using ::steadymap::testing::StoreVolume;

const Eigen::Vector3d kLongSizeM(0.4, 0.8, 0.6);

constexpr double kReachM = 0.075;

class SurfaceRelationsTest : public ::testing::Test {
 protected:
  SurfaceRelationsTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds a box with its lowest corner at `place`.
  TrackedObject* Put(const Eigen::Vector3d& place, const Eigen::Vector3d& size_m = kLongSizeM) {
    TrackedObject& object = map_.AddObject(place);
    const Eigen::Vector3d low = place - object.state().T_world_object.position_world;
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolume({Box(low, low + size_m)}, map_.scale()), &edit);
    return &object;
  }

  void SetScores(std::int8_t score, TrackedObject* object) {
    ObjectEdit edit = map_.Edit(object);
    for (const SurfaceLeaf& leaf : object->surface().leaves()) {
      edit.state().evidence.MutableLeaf(leaf.origin).score.fill(score);
    }
  }

  /// Returns the share of the found cells of an object that another one explains.
  double ExplainedShare(const TrackedObject* object, const TrackedObject* other) {
    return static_cast<double>(CountExplainedCells(*object, {other}, kReachM, map_.scale())) /
           static_cast<double>(CountLooks(*object).found);
  }

  WorkingMap map_{MapConfig()};
};

TEST_F(SurfaceRelationsTest, ASurfaceIsFreeWhereSomethingWasSeenBehindIt) {
  TrackedObject* object = Put({2.0, 0.0, 0.0});
  EXPECT_EQ(FreeShareOf(*object, FreeSpaceSince(map_.free_space(), map_.now())), 0.0);
  // Rays through the half of it with y < 0.4.
  for (int column = 0; column < 8; ++column) {
    for (int row = 0; row < 12; ++row) {
      const double y = 0.05 * column + 0.025;
      const double z = 0.05 * row + 0.025;
      map_.MarkFree({0.0, y, z}, {4.0, y, z}, map_.now());
    }
  }
  EXPECT_NEAR(FreeShareOf(*object, FreeSpaceSince(map_.free_space(), map_.now())), 0.5, 0.1);
}

TEST_F(SurfaceRelationsTest, ACoincidentSurfaceExplainsAllThatWasFound) {
  TrackedObject* object = Put({2.0, 0.0, 0.0});
  SetScores(2, object);
  EXPECT_EQ(ExplainedShare(object, Put({2.0, 0.0, 0.0})), 1.0);
}

TEST_F(SurfaceRelationsTest, ASurfaceThatSlidAlongItsPlaneExplainsTheRest) {
  TrackedObject* object = Put({2.0, 0.0, 0.0});
  SetScores(2, object);
  // Front, back, top and bottom for half of their length, and of the ends those that are inside.
  const double share = ExplainedShare(object, Put({2.0, 0.4, 0.0}));
  EXPECT_GT(share, 0.35);
  EXPECT_LT(share, 0.65);
}

TEST_F(SurfaceRelationsTest, ADistantSurfaceExplainsNothing) {
  TrackedObject* object = Put({2.0, 0.0, 0.0});
  SetScores(2, object);
  EXPECT_EQ(ExplainedShare(object, Put({2.0, 1.2, 0.0})), 0.0);
  EXPECT_EQ(CountExplainedCells(*object, {}, kReachM, map_.scale()), 0U);
}

TEST_F(SurfaceRelationsTest, WhatWasNotFoundNeedsNoExplanation) {
  TrackedObject* object = Put({2.0, 0.0, 0.0});
  SetScores(-2, object);
  const TrackedObject* other = Put({2.0, 0.0, 0.0});
  EXPECT_EQ(CountExplainedCells(*object, {other}, kReachM, map_.scale()), 0U);
}

TEST_F(SurfaceRelationsTest, ABoxInFrontHidesTheSideBehindIt) {
  const TrackedObject* object = Put({2.0, 0.0, 0.0});
  const double front_m2 = kLongSizeM.y() * kLongSizeM.z();
  const double all_m2 = 2.0 * (front_m2 + kLongSizeM.x() * (kLongSizeM.y() + kLongSizeM.z()));
  EXPECT_NEAR(HiddenShare(*object, *Put({1.4, 0.0, 0.0}), map_.scale()), front_m2 / all_m2, 0.05);
  // It covers half of the width.
  EXPECT_NEAR(
      HiddenShare(*object, *Put({1.4, 0.4, 0.0}), map_.scale()), 0.5 * front_m2 / all_m2, 0.05);
}

TEST_F(SurfaceRelationsTest, AContinuationInTheSamePlaneHidesNothing) {
  const TrackedObject* object = Put({2.0, 0.0, 0.0}, {0.1, 0.8, 0.6});
  const TrackedObject* other = Put({2.0, 0.8, 0.0}, {0.1, 0.8, 0.6});
  EXPECT_LT(HiddenShare(*object, *other, map_.scale()), 0.1);
}

}  // namespace
}  // namespace steadymap
