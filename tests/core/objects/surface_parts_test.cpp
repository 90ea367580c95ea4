#include "core/objects/surface_parts.h"

#include <algorithm>
#include <numeric>
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

constexpr double kPointSpacingM = 0.05;

/// Returns `side` x `side` points of a horizontal square, one per voxel, that begins at `x_m`.
std::vector<OrientedPoint> Square(int side, double x_m, double z_m) {
  std::vector<OrientedPoint> points;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      points.push_back(
          {{x_m + kPointSpacingM * x, kPointSpacingM * y, z_m}, Eigen::Vector3d::UnitZ()});
    }
  }
  return points;
}

std::vector<OrientedPoint> Both(std::vector<OrientedPoint> a, const std::vector<OrientedPoint>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(FindConnectedParts, PointsFurtherThanTheReachAreApart) {
  const std::vector<OrientedPoint> points = Both(Square(6, 0.0, 0.0), Square(10, 0.4, 0.0));
  const std::vector<char> none(points.size(), 0);
  const auto parts = FindConnectedParts(points, none, 1.5 * kPointSpacingM);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].size(), 100U);
  EXPECT_EQ(parts[1].size(), 36U);
  EXPECT_EQ(FindConnectedParts(points, none, 0.2).size(), 1U);
}

TEST(FindConnectedParts, ExcludedPointsConnectNothing) {
  const std::vector<OrientedPoint> points = Square(10, 0.0, 0.0);
  std::vector<char> is_excluded(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x_m = points[i].position_world.x();
    if (x_m > 0.17 && x_m < 0.28) is_excluded[i] = 1;
  }
  EXPECT_EQ(FindConnectedParts(points, is_excluded, 1.5 * kPointSpacingM).size(), 2U);
  EXPECT_TRUE(FindConnectedParts({}, {}, kPointSpacingM).empty());
}

TEST(SpreadParts, EachPointGetsThePartOfTheNearestSeed) {
  const std::vector<OrientedPoint> points = Square(10, 0.0, 0.0);
  const std::vector<std::pair<std::size_t, std::size_t>> seeds = {{0, 1}, {99, 2}};
  const std::vector<std::size_t> part_of = SpreadParts(points, seeds, 1.5 * kPointSpacingM);
  EXPECT_EQ(part_of[1], 1U);
  EXPECT_EQ(part_of[98], 2U);
  EXPECT_EQ(std::count(part_of.begin(), part_of.end(), 0U), 0);
}

TEST(SpreadParts, AWayAcrossAnInnerEdgeIsLonger) {
  // A floor, and a wall at its end; the last row of the floor is nearer to the seed on the wall.
  std::vector<OrientedPoint> points = Square(8, 0.0, 0.0);
  const std::size_t floor_size = points.size();
  for (int z = 1; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      points.push_back({{0.4, kPointSpacingM * y, kPointSpacingM * z}, -Eigen::Vector3d::UnitX()});
    }
  }
  const std::size_t last_of_floor = floor_size - 4;
  const std::vector<std::pair<std::size_t, std::size_t>> seeds = {{4, 1}, {floor_size + 4, 2}};
  const double reach_m = 1.5 * kPointSpacingM;
  EXPECT_EQ(SpreadParts(points, seeds, reach_m)[last_of_floor], 2U);
  const std::vector<std::size_t> part_of = SpreadParts(points, seeds, reach_m, 1.0);
  EXPECT_EQ(part_of[last_of_floor], 1U);
  EXPECT_EQ(part_of.back(), 2U);
}

TEST(SpreadParts, WhatNoSeedReachesStaysInPartZero) {
  const std::vector<OrientedPoint> points = Both(Square(6, 0.0, 0.0), Square(6, 1.0, 0.0));
  const std::vector<std::pair<std::size_t, std::size_t>> seeds = {{0, 1}};
  const std::vector<std::size_t> part_of = SpreadParts(points, seeds, 1.5 * kPointSpacingM);
  EXPECT_EQ(std::count(part_of.begin(), part_of.end(), 1U), 36);
}

TEST(FindPlaneParts, AFloorIsLargeAndABoxTopOnItIsNot) {
  const std::vector<OrientedPoint> floor = Square(40, 0.0, 0.0);
  const std::vector<OrientedPoint> points = Both(floor, Square(10, 0.5, 0.4));
  const std::vector<PlanePart> planes = FindPlaneParts(
      points, kPointSpacingM * kPointSpacingM, 1.75 * kPointSpacingM, {.min_area_m2 = 1.5});
  ASSERT_EQ(planes.size(), 1U);
  std::vector<std::size_t> on_plane = planes.front().points;
  std::sort(on_plane.begin(), on_plane.end());
  std::vector<std::size_t> on_floor(floor.size());
  std::iota(on_floor.begin(), on_floor.end(), std::size_t{0});
  EXPECT_EQ(on_plane, on_floor);
  EXPECT_NEAR(planes.front().normal_world.z(), 1.0, 1e-9);
  EXPECT_NEAR(planes.front().center_world.z(), 0.0, 1e-9);
}

class DivideVoxelsTest : public ::testing::Test {
 protected:
  DivideVoxelsTest() {
    map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0));
    whole_ = &map_.AddObject({1.0, 0.0, 0.0});
    ObjectEdit edit = map_.Edit(whole_);
    const Solid boxes = {Box(Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.4, 0.4, 0.4)),
                         Box(Eigen::Vector3d(0.7, 0.0, 0.0), Eigen::Vector3d(1.1, 0.4, 0.4))};
    StoreVolume(MakeVolume(boxes, map_.scale()), &edit);
    edit.state().class_id = ClassId(7);
  }

  /// Returns the part of each surface point: 1 beyond the middle of the gap.
  std::vector<std::size_t> PartOfPoints() const {
    std::vector<std::size_t> part_of;
    for (const SurfaceLeaf& leaf : whole_->surface().leaves()) {
      for (const SurfaceVoxel& point : leaf.points) {
        part_of.push_back(point.position_object.x() > 0.55F ? 1 : 0);
      }
    }
    return part_of;
  }

  WorkingMap map_{MapConfig()};
  TrackedObject* whole_ = nullptr;
};

TEST_F(DivideVoxelsTest, EveryVoxelIsInOnePart) {
  const std::size_t voxels = whole_->volume().CountObservedVoxels();
  const std::size_t points = whole_->surface().point_count();
  const std::vector<TrackedObject*> parts = DivideVoxels(whole_, PartOfPoints(), 1, &map_);
  ASSERT_EQ(parts.size(), 1U);
  EXPECT_EQ(whole_->volume().CountObservedVoxels() + parts[0]->volume().CountObservedVoxels(),
            voxels);
  EXPECT_EQ(whole_->surface().point_count() + parts[0]->surface().point_count(), points);
  EXPECT_LT(whole_->bounds_object().max().x(), 0.55);
  EXPECT_GT(parts[0]->bounds_object().min().x(), 0.55);
  EXPECT_EQ(parts[0]->state().class_id, ClassId(7));
}

TEST_F(DivideVoxelsTest, ScoresGoWithTheSurface) {
  {
    ObjectEdit edit = map_.Edit(whole_);
    for (const SurfaceLeaf& leaf : whole_->surface().leaves()) {
      edit.state().evidence.MutableLeaf(leaf.origin).score.fill(2);
    }
  }
  const TrackedObject* part = DivideVoxels(whole_, PartOfPoints(), 1, &map_).front();
  for (const TrackedObject* object : {static_cast<const TrackedObject*>(whole_), part}) {
    std::size_t scored = 0;
    for (const LeafEvidence& leaf : object->state().evidence.leaves) {
      scored += static_cast<std::size_t>(std::count(leaf.score.begin(), leaf.score.end(), 2));
    }
    EXPECT_GT(scored, 0U);
    EXPECT_LE(scored, object->surface().point_count());
  }
}

TEST_F(DivideVoxelsTest, WithoutPartsNothingChanges) {
  const std::size_t voxels = whole_->volume().CountObservedVoxels();
  const std::vector<std::size_t> part_of(whole_->surface().point_count(), 0);
  EXPECT_TRUE(DivideVoxels(whole_, part_of, 0, &map_).empty());
  EXPECT_EQ(whole_->volume().CountObservedVoxels(), voxels);
}

}  // namespace
}  // namespace steadymap
