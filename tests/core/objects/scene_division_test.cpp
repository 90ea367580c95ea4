// A floor, a wall and boxes, fused as one scene without labels; the space above the floor is free.

#include "core/objects/scene_division.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::DistanceFrom;
using ::steadymap::testing::MakeVolumeAt;
using ::steadymap::testing::Solid;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::WithWeight;

Box FloorSlab() { return {Eigen::Vector3d(-2.0, -2.0, -0.4), Eigen::Vector3d(2.0, 2.0, 0.0)}; }

Box WallSlab() { return {Eigen::Vector3d(1.6, -2.0, -0.4), Eigen::Vector3d(2.0, 2.0, 2.0)}; }

Box StandingBox(double x_m, double y_m, double side_m = 0.4) {
  return {Eigen::Vector3d(x_m, y_m, -0.2), Eigen::Vector3d(x_m + side_m, y_m + side_m, side_m)};
}

class SceneDivisionTest : public ::testing::Test {
 protected:
  SceneDivisionTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  std::vector<TrackedObject*> Divide(const Solid& bodies) {
    return DivideSeen(bodies, [](const Eigen::Vector3d& point) { return point.z() > -0.12; });
  }

  /// Fuses what `is_observed` of a scene, looks through all the space around it, divides it and
  /// returns the objects.
  std::vector<TrackedObject*> DivideSeen(
      const Solid& bodies, const std::function<bool(const Eigen::Vector3d&)>& is_observed) {
    TrackedObject& scene = map_.AddObject(Eigen::Vector3d::Zero());
    const Box bounds(Eigen::Vector3d(-2.2, -2.2, -0.15), Eigen::Vector3d(1.75, 2.2, 2.2));
    {
      ObjectEdit edit = map_.Edit(&scene);
      StoreVolume(MakeVolumeAt(scene.state().T_world_object.position_world,
                               bodies,
                               bounds,
                               map_.scale(),
                               is_observed),
                  &edit);
    }
    {
      ObjectEdit edit = map_.Edit(&scene);
      edit.state().gaps = gaps_;
    }
    if (weight_ != 1.0F) {
      ObjectEdit edit = map_.Edit(&scene);
      StoreVolume(WithWeight(scene.volume(), weight_), &edit);
    }
    if (sees_around_) MarkFree(bodies);
    DivideScene(SceneDivisionParameters(), SurfaceMatchParameters(), &scene, &map_);
    EXPECT_TRUE(scene.is_deleted());
    return map_.TentativeObjects();
  }

  /// Marks the space at least a voxel from every surface.
  void MarkFree(const Solid& bodies) {
    constexpr int kColumns = 40;
    constexpr int kLevels = 20;
    const double step_m = 2.0 * map_.scale().voxel_size_m;
    for (int i = 0; i < kColumns * kColumns * kLevels; ++i) {
      const Eigen::Vector3i cell(i % kColumns, i / kColumns % kColumns, i / (kColumns * kColumns));
      const Eigen::Vector3d point =
          step_m * cell.cast<double>() + Eigen::Vector3d(-1.95, -1.95, 0.05);
      if (point.x() < 1.6 && DistanceFrom(bodies, point) > map_.scale().voxel_size_m) {
        map_.MarkFree(point, point, map_.now());
      }
    }
  }

  bool sees_around_ = true;
  float weight_ = 1.0F;  ///< Of all voxels.
  std::vector<SeenGap> gaps_;
  WorkingMap map_{MapConfig()};
};

TEST_F(SceneDivisionTest, ABoxOnTheFloorIsAnObject) {
  const std::vector<TrackedObject*> objects = Divide({FloorSlab(), StandingBox(0.0, 0.0)});
  ASSERT_EQ(objects.size(), 1U);
  const Box bounds = objects.front()->BoundsInWorld();
  EXPECT_TRUE(bounds.min().isApprox(Eigen::Vector3d(0.0, 0.0, 0.0), 0.1) ||
              bounds.min().norm() < 0.1);
  EXPECT_LT((bounds.max() - Eigen::Vector3d::Constant(0.4)).norm(), 0.1);
}

TEST_F(SceneDivisionTest, FloorAndWallBecomeBackground) {
  EXPECT_TRUE(Divide({FloorSlab(), WallSlab()}).empty());
  EXPECT_GT(map_.background().CountObservedVoxels(), 1000U);
}

TEST_F(SceneDivisionTest, BoxesApartAreTwoObjects) {
  EXPECT_EQ(Divide({FloorSlab(), StandingBox(0.0, 0.0), StandingBox(0.0, 0.6)}).size(), 2U);
}

TEST_F(SceneDivisionTest, PiecesWithASmallGapAreOneObject) {
  // Two pieces of one box: nothing was seen between y = 0.4 and y = 0.5.
  const Box box(Eigen::Vector3d(0.0, 0.0, -0.2), Eigen::Vector3d(0.4, 0.9, 0.4));
  const auto is_observed = [](const Eigen::Vector3d& point) {
    return point.z() > -0.12 && (point.z() < 0.12 || std::abs(point.y() - 0.45) > 0.04);
  };
  EXPECT_EQ(DivideSeen({FloorSlab(), box}, is_observed).size(), 1U);
}

TEST_F(SceneDivisionTest, BoxesOfWhichTheSidesFaceEachOtherAreTwoObjects) {
  EXPECT_EQ(Divide({FloorSlab(), StandingBox(0.0, 0.0), StandingBox(0.0, 0.5)}).size(), 2U);
}

TEST_F(SceneDivisionTest, ABoxThatFramesLookThroughIsTwoObjects) {
  // From the front, from above and from behind.
  for (int i = 0; i < 15; ++i) {
    const double x_m = i < 5 ? 0.0 : i < 10 ? (i - 5) * 0.1 : 0.4;
    const double z_m = i < 5 ? i * 0.1 : i < 10 ? 0.4 : (i - 10) * 0.1;
    const Eigen::Vector3d middle(x_m, 0.45, z_m);
    gaps_.push_back({.cell = {i, 0, 0},
                     .frames = 3,
                     .weight = 100.0,
                     .width_m = 0.1,
                     .middle_world = middle,
                     .view_sum_world = {100.0, 0.0}});
  }
  const Box box(Eigen::Vector3d(0.0, 0.0, -0.2), Eigen::Vector3d(0.4, 0.9, 0.4));
  EXPECT_EQ(Divide({FloorSlab(), box}).size(), 2U);
  // A single box beside the gap remains one.
  EXPECT_EQ(Divide({FloorSlab(), StandingBox(0.0, 0.0)}).size(), 3U);
}

TEST_F(SceneDivisionTest, NoiseOnTheFloorDoesNotConnectThings) {
  const Box noise(Eigen::Vector3d(0.0, 0.3, -0.2), Eigen::Vector3d(0.4, 0.9, 0.03));
  EXPECT_EQ(Divide({FloorSlab(), StandingBox(0.0, 0.0), noise, StandingBox(0.0, 0.8)}).size(), 2U);
}

TEST_F(SceneDivisionTest, ABoxOfWhichTwoSidesWereNotSeenIsAnObject) {
  const auto is_observed = [](const Eigen::Vector3d& point) {
    const bool is_of_box = (point - Eigen::Vector3d(0.2, 0.2, 0.2)).cwiseAbs().maxCoeff() < 0.35;
    return point.z() > -0.12 && !(is_of_box && std::abs(point.y() - 0.2) > 0.15);
  };
  EXPECT_EQ(DivideSeen({FloorSlab(), StandingBox(0.0, 0.0)}, is_observed).size(), 1U);
}

TEST_F(SceneDivisionTest, FloorThatAThingHidIsBackground) {
  for (TrackedObject* object : Divide({FloorSlab(), StandingBox(0.0, 0.0)})) map_.Delete(object);
  map_.EndFrame();
  map_.BeginFrame(Revision(2), Timestamp::FromSeconds(200.0));
  // The box was pushed by half of its length. A frame shows it and what it hid.
  const auto is_observed = [](const Eigen::Vector3d& point) {
    return point.z() > -0.12 && point.x() > 0.0 && point.x() < 0.4 && point.y() > 0.0 &&
           point.y() < 0.7;
  };
  const std::vector<TrackedObject*> objects =
      DivideSeen({FloorSlab(), StandingBox(0.0, 0.2)}, is_observed);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_GT(objects.front()->BoundsInWorld().min().y(), 0.12);
}

TEST_F(SceneDivisionTest, APieceOfFloorApartFromTheRestIsBackground) {
  const Box post(Eigen::Vector3d(1.1, 0.0, -0.2), Eigen::Vector3d(1.16, 0.06, 1.8));
  const auto is_observed = [](const Eigen::Vector3d& point) {
    const bool is_piece = point.x() > 0.9 && point.x() < 1.4 && std::abs(point.y()) < 0.2;
    return point.z() > -0.12 && (point.x() < 0.5 || is_piece);
  };
  EXPECT_TRUE(DivideSeen({FloorSlab(), post}, is_observed).empty());
}

TEST_F(SceneDivisionTest, ABoxAgainstAWallIsAnObject) {
  EXPECT_EQ(Divide({FloorSlab(), WallSlab(), StandingBox(1.25, 0.0)}).size(), 1U);
}

TEST_F(SceneDivisionTest, ACabinetWithALargeFrontIsAnObject) {
  const Box cabinet(Eigen::Vector3d(1.25, -0.6, -0.2), Eigen::Vector3d(1.7, 0.6, 1.6));
  const std::vector<TrackedObject*> objects = Divide({FloorSlab(), WallSlab(), cabinet});
  ASSERT_EQ(objects.size(), 1U);
  // With its front and top, at least.
  EXPECT_GT(objects.front()->SurfaceAreaM2(), 2.0);
}

TEST_F(SceneDivisionTest, AWallThatAThingDividesIsBackground) {
  // On both sides of the box, 1.3 square metres of the wall were seen.
  const Box box(Eigen::Vector3d(1.2, -0.2, -0.2), Eigen::Vector3d(1.7, 0.2, 0.6));
  const auto is_observed = [](const Eigen::Vector3d& point) {
    return point.z() > -0.12 && point.z() < 0.8 && (point.x() < 1.55 || std::abs(point.y()) > 0.2);
  };
  const std::vector<TrackedObject*> objects =
      DivideSeen({FloorSlab(), WallSlab(), box}, is_observed);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_LT(objects.front()->BoundsInWorld().sizes().y(), 0.6);
}

TEST_F(SceneDivisionTest, AThingOnATableIsAnObjectOfItsOwn) {
  const Box top(Eigen::Vector3d(-0.6, -0.5, 0.5), Eigen::Vector3d(0.6, 0.5, 0.7));
  const Box leg(Eigen::Vector3d(-0.3, -0.3, -0.2), Eigen::Vector3d(0.3, 0.3, 0.6));
  const Box thing(Eigen::Vector3d(-0.2, -0.2, 0.6), Eigen::Vector3d(0.15, 0.15, 1.0));
  const std::vector<TrackedObject*> objects = Divide({FloorSlab(), top, leg, thing});
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_LT(objects[0]->BoundsInWorld().max().z(), 0.82);
  EXPECT_GT(objects[1]->BoundsInWorld().min().z(), 0.6);
  EXPECT_NEAR(objects[1]->BoundsInWorld().max().z(), 1.0, 0.06);
}

TEST_F(SceneDivisionTest, ANarrowThingOnATableIsAnObjectOfItsOwn) {
  weight_ = 10.0F;
  const Box top(Eigen::Vector3d(-0.6, -0.5, 0.5), Eigen::Vector3d(0.6, 0.5, 0.7));
  const Box leg(Eigen::Vector3d(-0.3, -0.3, -0.2), Eigen::Vector3d(0.3, 0.3, 0.6));
  const Box mug(Eigen::Vector3d(0.0, 0.0, 0.6), Eigen::Vector3d(0.1, 0.1, 0.82));
  const std::vector<TrackedObject*> objects = Divide({FloorSlab(), top, leg, mug});
  ASSERT_EQ(objects.size(), 2U);
  EXPECT_LT(objects[0]->BoundsInWorld().max().z(), 0.75);
  EXPECT_NEAR(objects[1]->BoundsInWorld().max().z(), 0.82, 0.05);
  EXPECT_LT(objects[1]->BoundsInWorld().sizes().x(), 0.2);
}

TEST_F(SceneDivisionTest, APostOnATableIsAPartOfIt) {
  weight_ = 10.0F;
  const Box top(Eigen::Vector3d(-0.6, -0.5, 0.5), Eigen::Vector3d(0.6, 0.5, 0.7));
  const Box leg(Eigen::Vector3d(-0.3, -0.3, -0.2), Eigen::Vector3d(0.3, 0.3, 0.6));
  const Box post(Eigen::Vector3d(0.0, 0.0, 0.6), Eigen::Vector3d(0.1, 0.1, 1.4));
  const std::vector<TrackedObject*> objects = Divide({FloorSlab(), top, leg, post});
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_NEAR(objects[0]->BoundsInWorld().max().z(), 1.4, 0.05);
}

TEST_F(SceneDivisionTest, TheUpperEdgeOfATableIsAPartOfIt) {
  weight_ = 10.0F;
  const Box table(Eigen::Vector3d(-0.6, -0.5, -0.2), Eigen::Vector3d(0.6, 0.5, 0.7));
  // Of the side at x = 0.6, only a patch below the top was seen.
  const auto is_observed = [](const Eigen::Vector3d& point) {
    if (point.x() < 0.5) return point.z() > -0.12;
    return point.z() > 0.67 || (point.z() > 0.62 && std::abs(point.y()) < 0.08);
  };
  const std::vector<TrackedObject*> objects = DivideSeen({FloorSlab(), table}, is_observed);
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_NEAR(objects.front()->BoundsInWorld().max().x(), 0.6, 0.05);
}

TEST_F(SceneDivisionTest, PiecesOfAThingOnATableAreOneObject) {
  weight_ = 10.0F;
  const Box top(Eigen::Vector3d(-0.6, -0.5, 0.5), Eigen::Vector3d(0.6, 0.5, 0.7));
  const Box leg(Eigen::Vector3d(-0.3, -0.3, -0.2), Eigen::Vector3d(0.3, 0.3, 0.6));
  const Box thing(Eigen::Vector3d(-0.15, -0.25, 0.6), Eigen::Vector3d(0.15, 0.25, 0.95));
  // Nothing was seen of it between y = -0.04 and y = 0.04.
  const auto is_observed = [](const Eigen::Vector3d& point) {
    return point.z() > -0.12 && (point.z() < 0.72 || std::abs(point.y()) > 0.04);
  };
  EXPECT_EQ(DivideSeen({FloorSlab(), top, leg, thing}, is_observed).size(), 2U);
}

TEST_F(SceneDivisionTest, AThingNarrowerThanAFewVoxelsIsBackground) {
  EXPECT_TRUE(
      Divide({FloorSlab(), Box(Eigen::Vector3d(0.0, 0.0, -0.2), Eigen::Vector3d(0.05, 0.05, 0.8))})
          .empty());
}

TEST_F(SceneDivisionTest, ASmallThingIsAnObjectIfItWasSeenWell) {
  weight_ = 10.0F;
  EXPECT_EQ(Divide({FloorSlab(), StandingBox(0.0, 0.0, 0.2)}).size(), 1U);
}

TEST_F(SceneDivisionTest, AThingThatWasHardlySeenIsBackground) {
  weight_ = 0.1F;
  EXPECT_TRUE(Divide({FloorSlab(), StandingBox(0.0, 0.0, 0.2)}).empty());
  EXPECT_EQ(Divide({FloorSlab(), StandingBox(0.0, 0.0, 0.6)}).size(), 1U);
}

TEST_F(SceneDivisionTest, WhatIsInContactWithKnownBackgroundIsNoise) {
  EXPECT_TRUE(Divide({FloorSlab(), WallSlab()}).empty());
  map_.EndFrame();
  map_.BeginFrame(Revision(2), Timestamp::FromSeconds(200.0));
  const auto slab_before_wall = [](double depth_m) {
    return Box(Eigen::Vector3d(1.6 - depth_m, -0.25, 0.6), Eigen::Vector3d(1.8, 0.25, 1.1));
  };
  // A layer of noise, and a cabinet.
  EXPECT_TRUE(DivideSeen({slab_before_wall(0.06)}, [](const Eigen::Vector3d& point) {
                return point.x() < 1.6;
              }).empty());
  EXPECT_EQ(DivideSeen({slab_before_wall(0.2)},
                       [](const Eigen::Vector3d& point) { return point.x() < 1.6; })
                .size(),
            1U);
}

TEST_F(SceneDivisionTest, ALegIsBackground) {
  const Box leg(Eigen::Vector3d(0.02, 0.0, -0.2), Eigen::Vector3d(0.08, 0.12, 0.8));
  EXPECT_TRUE(Divide({FloorSlab(), leg}).empty());
}

TEST_F(SceneDivisionTest, APieceInUnknownSpaceIsNoObject) {
  sees_around_ = false;
  const Box piece(Eigen::Vector3d(0.0, 0.0, 0.8), Eigen::Vector3d(0.4, 0.4, 1.2));
  EXPECT_TRUE(DivideSeen({piece}, [](const Eigen::Vector3d& point) {
                return point.x() < 0.1;  // One side.
              }).empty());
}

}  // namespace
}  // namespace steadymap
