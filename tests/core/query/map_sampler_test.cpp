// Closed-form oracles for queries of a whole map: a floor and boxes with known distances.

#include "core/query/map_sampler.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "core/map/map_counts.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AddObject;
using ::steadymap::testing::BoxObject;
using ::steadymap::testing::BoxOverFloor;
using ::steadymap::testing::FloorMap;
using ::steadymap::testing::kBoxPlace;
using ::steadymap::testing::kBoxSizeM;
using ::steadymap::testing::kBoxYawRad;

TEST(MapSampler, TheNearestSurfaceAnswersForAPoint) {
  const MapSnapshot map = BoxOverFloor();
  MapSampler sampler(map);
  const Eigen::Isometry3d T_world_object = kBoxPlace.ToIsometry();
  const MapDistance above_floor = sampler.Sample({-1.0, -1.0, 0.07});
  EXPECT_TRUE(above_floor.sample.known);
  EXPECT_NEAR(above_floor.sample.distance_m, 0.07, 1e-4);
  EXPECT_EQ(above_floor.object, kBackgroundId);
  EXPECT_EQ(above_floor.class_id, ClassId(0));

  const MapDistance before_box = sampler.Sample(T_world_object * Eigen::Vector3d(0.37, 0.02, 0.03));
  EXPECT_TRUE(before_box.sample.known);
  EXPECT_NEAR(before_box.sample.distance_m, 0.07, 1e-4);
  EXPECT_EQ(before_box.object, ObjectId(3));
  EXPECT_EQ(before_box.class_id, ClassId(103));
  EXPECT_NEAR((before_box.sample.gradient -
               Eigen::Vector3d(std::cos(kBoxYawRad), std::sin(kBoxYawRad), 0.0))
                  .norm(),
              0.0,
              1e-3);

  const MapDistance inside_box = sampler.Sample(T_world_object * Eigen::Vector3d(0.25, 0.0, 0.0));
  EXPECT_NEAR(inside_box.sample.distance_m, -0.05, 1e-4);
  EXPECT_FALSE(sampler.Sample({-1.0, 1.0, 1.0}).sample.known);
}

TEST(MapSampler, DistancesAreThoseOfTheUnionWhereverTheyAreKnown) {
  const MapSnapshot map = BoxOverFloor();
  MapSampler sampler(map);
  const Eigen::Isometry3d T_object_world = kBoxPlace.ToIsometry().inverse();
  const Box body(-0.5 * kBoxSizeM, 0.5 * kBoxSizeM);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> coordinate(-1.2, 1.4);
  std::size_t by_object = 0;
  for (int i = 0; i < 50'000; ++i) {
    const Eigen::Vector3d point(coordinate(random), coordinate(random), coordinate(random));
    const MapDistance found = sampler.Sample(point);
    if (!found.sample.known) continue;
    const double box_m = testing::DistanceFrom({body}, T_object_world * point);
    const double floor_m = point.z();
    const double truth_m = std::abs(box_m) < std::abs(floor_m) ? box_m : floor_m;
    // Interpolation rounds the edges of the box.
    ASSERT_NEAR(found.sample.distance_m, truth_m, 0.03) << point.transpose();
    by_object += found.object == ObjectId(3) ? 1 : 0;
  }
  EXPECT_GT(by_object, 100U);
}

TEST(MapSampler, RaysMeetTheNearestOfBackgroundAndObjects) {
  const MapSnapshot map = BoxOverFloor();
  MapSampler sampler(map);
  const Eigen::Vector3d over_box(0.5, -0.3, 3.0);
  const MapRayHit top = sampler.CastRay(over_box, -Eigen::Vector3d::UnitZ(), 10.0);
  EXPECT_TRUE(top.hit.hit);
  EXPECT_NEAR(top.hit.range_m, 3.0 - 0.85, 1e-3);
  EXPECT_NEAR((top.hit.point_m - Eigen::Vector3d(0.5, -0.3, 0.85)).norm(), 0.0, 1e-3);
  EXPECT_NEAR(top.hit.normal.z(), 1.0, 1e-3);
  EXPECT_EQ(top.object, ObjectId(3));
  EXPECT_EQ(top.class_id, ClassId(103));

  const MapRayHit floor = sampler.CastRay({-1.0, 0.5, 3.0}, -Eigen::Vector3d::UnitZ(), 10.0);
  EXPECT_TRUE(floor.hit.hit);
  EXPECT_NEAR(floor.hit.range_m, 3.0, 1e-3);
  EXPECT_EQ(floor.object, kBackgroundId);

  EXPECT_FALSE(sampler.CastRay(over_box, -Eigen::Vector3d::UnitZ(), 2.0).hit.hit);
  EXPECT_FALSE(sampler.CastRay(over_box, Eigen::Vector3d::UnitZ(), 10.0).hit.hit);
}

TEST(MapSampler, RaysFromBetweenObjectAndFloorMeetTheFloorAlone) {
  const MapSnapshot map = BoxOverFloor();
  MapSampler sampler(map);
  const MapRayHit hit = sampler.CastRay({0.5, -0.3, 0.25}, -Eigen::Vector3d::UnitZ(), 10.0);
  EXPECT_EQ(hit.object, kBackgroundId);
  EXPECT_NEAR(hit.hit.range_m, 0.25, 1e-3);
}

TEST(MapSampler, TheNormalTurnsWithTheObject) {
  const MapSnapshot map = BoxOverFloor();
  MapSampler sampler(map);
  const Eigen::Vector3d side(std::cos(kBoxYawRad), std::sin(kBoxYawRad), 0.0);
  const MapRayHit hit = sampler.CastRay(kBoxPlace.position_world + 2.0 * side, -side, 10.0);
  EXPECT_NEAR(hit.hit.range_m, 2.0 - 0.3, 1e-3);
  EXPECT_NEAR((hit.hit.normal - side).norm(), 0.0, 1e-3);
}

TEST(MapSampler, OnlyPresentObjectsAreShown) {
  MapSnapshot map = FloorMap();
  MapObject object = BoxObject(ObjectId(3), kBoxSizeM, kBoxPlace);
  for (const ObjectStatus standing : {ObjectStatus::kTentative, ObjectStatus::kArchived}) {
    object.status = standing;
    AddObject(object, &map);
    MapSampler sampler(map);
    EXPECT_FALSE(sampler.Sample({0.5, -0.3, 0.85}).sample.known);
    EXPECT_EQ(sampler.CastRay({0.5, -0.3, 3.0}, -Eigen::Vector3d::UnitZ(), 9.0).object,
              kBackgroundId);
  }
}

TEST(MapSampler, OfEquallyNearObjectsTheLowerIdAnswers) {
  MapSnapshot map = FloorMap();
  for (const std::uint64_t id : {9U, 2U, 5U}) {
    AddObject(BoxObject(ObjectId(id), kBoxSizeM, kBoxPlace), &map);
  }
  MapSampler sampler(map);
  EXPECT_EQ(sampler.Sample({0.5, -0.3, 0.9}).object, ObjectId(2));
}

TEST(MapSampler, AnEmptyMapKnowsNothing) {
  const MapSnapshot map;
  MapSampler sampler(map);
  EXPECT_FALSE(sampler.Sample(Eigen::Vector3d::Zero()).sample.known);
  EXPECT_FALSE(sampler.CastRay(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), 9.0).hit.hit);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(sampler.Sample({nan, 0.0, 0.0}).sample.known);
}

/// Returns a map of the floor and a wall of one square metre across the x axis at 100 m.
MapSnapshot FloorAndFarWall() {
  MapSnapshot map = FloorMap();
  const TsdfGrid wall = testing::WallVolume(100.0);
  wall.ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    LeafVoxels voxels;
    wall.LoadLeaf(origin, &voxels);
    map.background.MutableTile(origin).StoreLeaf(origin, voxels);
  });
  return map;
}

/// Returns the number of steps of a ray along x above the floor.
std::uint64_t StepsOfRay(const MapSnapshot& map, double max_range_m) {
  MapSampler sampler(map);
  sampler.CastRay({0.0, 0.0, 0.3}, Eigen::Vector3d::UnitX(), max_range_m);
  return sampler.work().steps();
}

TEST(MapSampler, EmptySpaceIsCrossedByTheTileInsteadOfByTheLeaf) {
  const MapSnapshot map = FloorAndFarWall();
  MapSampler sampler(map);
  const MapRayHit hit = sampler.CastRay({0.0, 0.0, 0.42}, Eigen::Vector3d::UnitX(), 200.0);
  EXPECT_NEAR(hit.hit.range_m, 100.0, 1e-3);
  // 30 tiles, some leaves in the tiles of the floor and the wall, and some voxels in front of the
  // wall. A traversal by leaves alone takes 250 steps.
  EXPECT_LT(sampler.work().steps(), 70U);
}

TEST(MapSampler, WhatLiesBeyondTheMapTakesNoStep) {
  const MapSnapshot map = FloorMap();
  EXPECT_EQ(StepsOfRay(map, 10.0), StepsOfRay(map, 1000.0));
  MapSampler sampler(map);
  sampler.CastRay({0.0, 0.0, 50.0}, Eigen::Vector3d::UnitX(), 1000.0);
  EXPECT_LE(sampler.work().steps(), 2U) << "passes above the whole map";
}

TEST(MapSampler, EndsWithinAStretchOnceItIsCancelled) {
  const MapSnapshot map = BoxOverFloor();
  const Cancellation cancellation;
  MapSampler sampler(map, QueryWork(cancellation, 100'000'000));
  const auto cast = [&](int i) {
    sampler.CastRay({-1.9, 0.001 * i, 0.05}, Eigen::Vector3d::UnitX(), 10.0);
  };
  for (int i = 0; i < 100; ++i) cast(i);
  ASSERT_TRUE(sampler.work().status().ok());
  const std::uint64_t before = sampler.work().steps();
  cancellation.Cancel();
  for (int i = 0; sampler.work().status().ok(); ++i) cast(i % 100);
  EXPECT_LE(sampler.work().steps(), before + 2 * QueryWork::kStepsPerCheck);
}

/// Returns the side of the empty cube around an empty leaf position, after a check of all leaves in
/// the cube. Returns 0 if the leaf exists.
int CheckEmptySide(const VoxelReader& volume, LeafOrigin origin) {
  if (volume.FindLeaf(origin)) return 0;
  const int side = volume.EmptySideAt(origin);
  EXPECT_EQ(side & (side - 1), 0);
  for (std::int32_t x = origin.x & -side; x < (origin.x & -side) + side; x += kLeafSide) {
    for (std::int32_t y = origin.y & -side; y < (origin.y & -side) + side; y += kLeafSide) {
      for (std::int32_t z = origin.z & -side; z < (origin.z & -side) + side; z += kLeafSide) {
        EXPECT_FALSE(volume.FindLeaf({x, y, z})) << x << ' ' << y << ' ' << z;
      }
    }
  }
  return side;
}

TEST(EmptySide, CubesHoldNoLeafAndAreNoSmallerThanTheyNeedBe) {
  const MapSnapshot map = FloorAndFarWall();
  const TsdfGrid floor = testing::FloorVolume(map.scale);
  EXPECT_EQ(CheckEmptySide(map.background, {0, 0, 16}), 8) << "in a tile of the floor";
  EXPECT_EQ(CheckEmptySide(map.background, {0, 0, 64}), 64) << "above it";
  EXPECT_EQ(CheckEmptySide(map.background, {-8, -8, -2000}), 64);
  EXPECT_EQ(CheckEmptySide(floor, {0, 0, 16}), 8);
  EXPECT_EQ(CheckEmptySide(floor, {0, 0, 64}), 64);
  EXPECT_EQ(CheckEmptySide(floor, {0, 0, -520}), 64);
}

TEST(CountMap, FreeSpaceAndEvidenceTakeMemory) {
  MapSnapshot map = FloorMap();
  const std::size_t floor_bytes = CountMap(map).memory_bytes;
  std::vector<LeafOrigin> changed_blocks;
  map.free_space.MarkRay({0.05, 0.05, 1.05}, {0.95, 0.05, 1.05}, RayTime(), &changed_blocks);
  const std::size_t free_bytes = map.free_space.memory_bytes();
  EXPECT_GT(free_bytes, 0U);
  EXPECT_EQ(CountMap(map).memory_bytes, floor_bytes + free_bytes);
  MapObject object = BoxObject(ObjectId(1), kBoxSizeM, kBoxPlace);
  object.evidence.leaves.resize(10);
  AddObject(object, &map);
  EXPECT_GE(CountMap(map).memory_bytes,
            floor_bytes + free_bytes + object.volume->memory_bytes() + 10 * sizeof(LeafEvidence));
}

TEST(CountMap, BackgroundAndObjectsAreCounted) {
  MapSnapshot map = FloorMap();
  const MapCounts floor = CountMap(map);
  EXPECT_EQ(floor.leaves, map.background.leaf_count());
  EXPECT_EQ(floor.present_objects, 0U);
  MapObject object = BoxObject(ObjectId(1), kBoxSizeM, kBoxPlace);
  AddObject(object, &map);
  const MapCounts present = CountMap(map);
  EXPECT_EQ(present.present_objects, 1U);
  EXPECT_EQ(present.leaves, floor.leaves + object.volume->leaf_count());
  EXPECT_EQ(present.voxels, floor.voxels + object.volume->CountObservedVoxels());
  EXPECT_EQ(present.memory_bytes, floor.memory_bytes + object.volume->memory_bytes());
  object.status = ObjectStatus::kArchived;
  AddObject(object, &map);
  const MapCounts archived = CountMap(map);
  EXPECT_EQ(archived.present_objects, 0U);
  EXPECT_EQ(archived.archived_objects, 1U);
  EXPECT_EQ(archived.voxels, floor.voxels);
  EXPECT_EQ(archived.memory_bytes, present.memory_bytes) << "it is still in memory";
}

}  // namespace
}  // namespace steadymap
