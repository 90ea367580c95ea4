// States of points and rays with known ground truth: a floor, a box above it, and observed free
// space.

#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/query/map_sampler.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AddObject;
using ::steadymap::testing::BoxObject;
using ::steadymap::testing::BoxOverFloor;
using ::steadymap::testing::FloorMap;
using ::steadymap::testing::kBoxPlace;
using ::steadymap::testing::kBoxSizeM;

const Eigen::Vector3d kDown = -Eigen::Vector3d::UnitZ();

void LookThrough(const Eigen::Vector3d& from, const Eigen::Vector3d& to, MapSnapshot* map) {
  std::vector<LeafOrigin> changed;
  // Marks single points, since the traversal of a whole ray may skip a cell.
  constexpr int kPoints = 5000;
  for (int i = 0; i <= kPoints; ++i) {
    const Eigen::Vector3d point = from + (to - from) * i / kPoints;
    map->free_space.MarkRay(point, point, RayTime(), &changed);
  }
}

PointState StateAt(const MapSnapshot& map, const Eigen::Vector3d& point) {
  return MapSampler(map).Sample(point).state;
}

TEST(PointState, FollowsTheSideOfTheSurfaceWithinTheTruncation) {
  const MapSnapshot map = FloorMap();
  EXPECT_EQ(StateAt(map, {0.5, 0.5, 0.01}), PointState::kFree);
  EXPECT_EQ(StateAt(map, {0.5, 0.5, 0.07}), PointState::kFree);
  EXPECT_EQ(StateAt(map, {0.5, 0.5, -0.01}), PointState::kSurface);
  EXPECT_EQ(StateAt(map, {0.5, 0.5, -0.07}), PointState::kSurface);
  EXPECT_EQ(StateAt(map, {0.5, 0.5, 1.0}), PointState::kUnknown);
  EXPECT_EQ(StateAt(map, {0.5, 0.5, -1.0}), PointState::kUnknown);
  const double nan = std::nan("");
  EXPECT_EQ(StateAt(map, {nan, 0.5, 0.1}), PointState::kUnknown);
  EXPECT_EQ(StateAt(map, {1e300, 0.5, 0.1}), PointState::kUnknown);
}

TEST(PointState, SpaceThatWasLookedThroughIsFreeWithoutADistance) {
  MapSnapshot map = FloorMap();
  LookThrough({0.5, 0.5, 2.0}, {0.5, 0.5, 0.5}, &map);
  MapSampler sampler(map);
  const MapDistance above = sampler.Sample({0.5, 0.5, 1.0});
  EXPECT_EQ(above.state, PointState::kFree);
  EXPECT_FALSE(above.sample.known);
  EXPECT_EQ(sampler.Sample({0.7, 0.5, 1.0}).state, PointState::kUnknown) << "beside it";
}

TEST(PointState, ASurfaceThatCameLaterCountsMoreThanFreeSpace) {
  MapSnapshot map = FloorMap();
  LookThrough({0.5, 0.5, 2.0}, {0.5, 0.5, -2.0}, &map);
  EXPECT_EQ(StateAt(map, {0.5, 0.5, -0.1}), PointState::kSurface);
}

TEST(PointState, TheInsideOfAnObjectIsNotFreeBecauseItOnceWas) {
  MapSnapshot map = FloorMap();
  const Eigen::Vector3d inside = kBoxPlace.position_world;  // Beyond the truncation band.
  LookThrough(inside - Eigen::Vector3d::UnitX(), inside + Eigen::Vector3d::UnitX(), &map);
  EXPECT_EQ(StateAt(map, inside), PointState::kFree);
  MapObject box = BoxObject(ObjectId(3), kBoxSizeM, kBoxPlace);
  for (const ObjectStatus standing : {ObjectStatus::kPresent, ObjectStatus::kTentative}) {
    box.status = standing;
    AddObject(box, &map);
    EXPECT_EQ(StateAt(map, inside), PointState::kUnknown);
  }
  box.status = ObjectStatus::kArchived;
  AddObject(box, &map);
  EXPECT_EQ(StateAt(map, inside), PointState::kFree) << "it has gone";
}

TEST(PointState, BehindAnySurfaceIsNotFreeThoughAnotherIsNearer) {
  MapSnapshot map = FloorMap();
  // The box extends 20 cm below the floor surface.
  AddObject(BoxObject(ObjectId(1), {1.0, 1.0, 1.0}, {.position_world = {0.0, 0.0, 0.3}}), &map);
  const MapDistance sample = MapSampler(map).Sample({0.4, 0.0, 0.05});
  EXPECT_EQ(sample.object, kBackgroundId) << "5 cm above the floor, 10 cm behind the box's side";
  EXPECT_NEAR(sample.sample.distance_m, 0.05, 1e-3);
  EXPECT_EQ(sample.state, PointState::kSurface);
}

TEST(StateOfRay, IsFreeWhereAllOfItIs) {
  MapSnapshot map = FloorMap();
  LookThrough({-0.95, 0.05, 1.05}, {0.95, 0.05, 1.05}, &map);
  MapSampler sampler(map);
  const Eigen::Vector3d origin(-0.9, 0.05, 1.05);
  const MapRayHit within = sampler.CastRay(origin, Eigen::Vector3d::UnitX(), 1.5);
  EXPECT_EQ(within.state, PointState::kFree);
  EXPECT_DOUBLE_EQ(within.free_until_m, 1.5);
  // The last free cell ends at x = 1.
  const MapRayHit beyond = sampler.CastRay(origin, Eigen::Vector3d::UnitX(), 5.0);
  EXPECT_EQ(beyond.state, PointState::kUnknown);
  EXPECT_NEAR(beyond.free_until_m, 1.9, 1e-9);
  const MapRayHit aside = sampler.CastRay(origin, Eigen::Vector3d::UnitY(), 5.0);
  EXPECT_EQ(aside.state, PointState::kUnknown);
  EXPECT_NEAR(aside.free_until_m, 0.05, 1e-9) << "the rest of its cell";
}

TEST(StateOfRay, IsSurfaceWhereItMeetsOneThroughFreeSpace) {
  MapSnapshot map = FloorMap({.voxel_size_m = 0.05, .truncation_m = 0.2});
  LookThrough({0.55, 0.55, 2.0}, {0.55, 0.55, 0.15}, &map);
  const MapRayHit hit = MapSampler(map).CastRay({0.55, 0.55, 1.9}, kDown, 10.0);
  EXPECT_EQ(hit.state, PointState::kSurface);
  EXPECT_NEAR(hit.hit.range_m, 1.9, 1e-3);
  EXPECT_DOUBLE_EQ(hit.free_until_m, hit.hit.range_m);
}

TEST(StateOfRay, KnowsWhereTheSpaceBeforeASurfaceIsUnknown) {
  MapSnapshot map = FloorMap();
  const MapRayHit unseen = MapSampler(map).CastRay({0.55, 0.55, 1.9}, kDown, 10.0);
  EXPECT_EQ(unseen.state, PointState::kSurface);
  EXPECT_EQ(unseen.free_until_m, 0.0);
  LookThrough({0.55, 0.55, 2.0}, {0.55, 0.55, 0.55}, &map);
  const MapRayHit in_part = MapSampler(map).CastRay({0.55, 0.55, 1.9}, kDown, 10.0);
  EXPECT_EQ(in_part.state, PointState::kSurface);
  EXPECT_NEAR(in_part.free_until_m, 1.9 - 0.5, 1e-9);
}

TEST(StateOfRay, EndsAtAnObjectInWhatWasFree) {
  MapSnapshot map = FloorMap();
  const Eigen::Vector3d middle = kBoxPlace.position_world;
  LookThrough(middle + Eigen::Vector3d::UnitZ(), middle - 0.4 * Eigen::Vector3d::UnitZ(), &map);
  AddObject(BoxObject(ObjectId(3), kBoxSizeM, kBoxPlace), &map);
  const MapRayHit hit =
      MapSampler(map).CastRay(middle + 0.9 * Eigen::Vector3d::UnitZ(), kDown, 9.0);
  EXPECT_EQ(hit.state, PointState::kSurface);
  EXPECT_NEAR(hit.hit.range_m, 0.9 - 0.25, 1e-3);
  EXPECT_DOUBLE_EQ(hit.free_until_m, hit.hit.range_m);
  const MapRayHit from_within = MapSampler(map).CastRay(middle, Eigen::Vector3d::UnitZ(), 0.2);
  EXPECT_EQ(from_within.state, PointState::kUnknown);
  EXPECT_EQ(from_within.free_until_m, 0.0);
}

TEST(StateOfRay, PointsOfItsFreePartAreFree) {
  MapSnapshot map = BoxOverFloor();
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-1.5, 1.5);
  const auto point = [&] {
    return Eigen::Vector3d(coordinate(random), coordinate(random), coordinate(random) + 1.5);
  };
  std::vector<LeafOrigin> changed;
  for (int i = 0; i < 3000; ++i) map.free_space.MarkRay(point(), point(), RayTime(), &changed);
  MapSampler sampler(map);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::size_t checked = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin = point();
    const Eigen::Vector3d direction = (point() - origin).normalized();
    const MapRayHit ray = sampler.CastRay(origin, direction, 3.0);
    ASSERT_LE(ray.free_until_m, ray.hit.hit ? ray.hit.range_m : 3.0);
    ASSERT_EQ(ray.state == PointState::kSurface, ray.hit.hit);
    const double range_m = share(random) * ray.free_until_m;
    const double step_m = 0.5 * map.scale.voxel_size_m;
    bool is_free = false;
    for (const double nearby_m : {range_m, range_m - step_m, range_m + step_m}) {
      is_free = is_free || sampler.Sample(origin + nearby_m * direction).state == PointState::kFree;
    }
    ASSERT_TRUE(is_free || ray.free_until_m == 0.0) << range_m << " of " << ray.free_until_m;
    checked += ray.free_until_m > 0.3 ? 1 : 0;
  }
  EXPECT_GT(checked, 200U);
}

TEST(StateOfRay, LongFreeRaysTakeAStepABlock) {
  MapSnapshot map;
  LookThrough({0.05, 0.05, 0.05}, {99.95, 0.05, 0.05}, &map);
  MapSampler sampler(map);
  const MapRayHit ray = sampler.CastRay({0.05, 0.05, 0.05}, Eigen::Vector3d::UnitX(), 90.0);
  EXPECT_EQ(ray.state, PointState::kFree);
  EXPECT_LT(sampler.work().steps(), 130U) << "113 blocks of 8 cells of 10 cm";
}

}  // namespace
}  // namespace steadymap
