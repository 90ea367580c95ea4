#include "core/volume/free_space.h"

#include <bit>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr double kCellM = 0.1;

constexpr Timestamp At(double seconds) { return Timestamp::FromSeconds(seconds); }

constexpr RayTime kRayTime{At(100.0), At(101.0)};

/// Marks the cells around `place` along x, of one block, seen by a session at a time.
void MarkAround(double place_m, double session_start_s, double time_s, FreeSpace* free_space) {
  std::vector<LeafOrigin> changed;
  free_space->MarkRay(
      {place_m, 0.05, 0.05}, {place_m, 0.05, 0.05}, {At(session_start_s), At(time_s)}, &changed);
}

std::size_t CountFreeCells(const FreeSpace& free_space) {
  std::size_t count = 0;
  free_space.ForEachBlock([&](LeafOrigin, const FreeBlock& block) {
    for (const std::uint64_t word : block.cells)
      count += static_cast<std::size_t>(std::popcount(word));
  });
  return count;
}

TEST(FreeSpace, KnowsNothingBeforeARayPassed) {
  const FreeSpace free_space(kCellM);
  EXPECT_FALSE(free_space.IsFree({0.05, 0.05, 0.05}));
  EXPECT_FALSE(free_space.IsFree({-1000.0, 0.0, 1000.0}));
}

TEST(FreeSpace, MarksTheCellsThatARayPassesAndNoOther) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.45, 0.05, 0.05}, kRayTime, &changed);
  for (int i = -6; i <= 4; ++i) {
    const double x = kCellM * i + 0.05;
    EXPECT_TRUE(free_space.IsFree({x, 0.05, 0.05})) << x;
    EXPECT_FALSE(free_space.IsFree({x, 0.15, 0.05})) << x;
    EXPECT_FALSE(free_space.IsFree({x, -0.05, 0.05})) << x;
    EXPECT_FALSE(free_space.IsFree({x, 0.05, 0.15})) << x;
  }
  EXPECT_FALSE(free_space.IsFree({-0.65, 0.05, 0.05}));
  EXPECT_FALSE(free_space.IsFree({0.55, 0.05, 0.05}));
  EXPECT_EQ(CountFreeCells(free_space), 11U);
}

TEST(FreeSpace, MarksASlantedRayOnlyWhereItPasses) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  const Eigen::Vector3d from(0.31, -0.77, 1.23);
  const Eigen::Vector3d to(2.4, 1.1, -0.6);
  free_space.MarkRay(from, to, kRayTime, &changed);
  EXPECT_TRUE(free_space.IsFree(from));
  const Eigen::Vector3d direction = (to - from).normalized();
  free_space.ForEachBlock([&](LeafOrigin origin, const FreeBlock& block) {
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (!IsSet(block.cells, offset)) continue;
      const Eigen::Vector3i cell(origin.x + static_cast<int>(offset >> 6),
                                 origin.y + static_cast<int>((offset >> 3) & 7),
                                 origin.z + static_cast<int>(offset & 7));
      const Eigen::Vector3d center = (cell.cast<double>().array() + 0.5) * kCellM;
      const double off_ray_m = (center - from).cross(direction).norm();
      EXPECT_LE(off_ray_m, 0.5 * std::sqrt(3.0) * kCellM) << cell.transpose();
    }
  });
  // The points are one cell apart, so a cell contains at most two of them.
  EXPECT_GE(CountFreeCells(free_space),
            static_cast<std::size_t>(0.5 * (to - from).norm() / kCellM));
}

TEST(FreeSpace, MarksOneCellForARayWithoutLength) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({0.05, 0.05, 0.05}, {0.05, 0.05, 0.05}, kRayTime, &changed);
  EXPECT_EQ(CountFreeCells(free_space), 1U);
  EXPECT_TRUE(free_space.IsFree({0.05, 0.05, 0.05}));
}

TEST(FreeSpace, ReportsEachBlockThatChangedAndNoneThatDidNot) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.45, 0.05, 0.05}, kRayTime, &changed);
  EXPECT_EQ(changed, (std::vector<LeafOrigin>{{-8, 0, 0}, {0, 0, 0}}));
  changed.clear();
  const FreeSpace before = free_space;
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.45, 0.05, 0.05}, kRayTime, &changed);
  EXPECT_TRUE(changed.empty());
  EXPECT_EQ(free_space, before);
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.65, 0.05, 0.05}, kRayTime, &changed);
  EXPECT_EQ(changed, (std::vector<LeafOrigin>{{0, 0, 0}}));
}

TEST(FreeSpace, IsWhatItsBlocksSay) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({0.05, 0.05, 0.05}, {2.0, 1.0, -1.0}, kRayTime, &changed);
  FreeSpace copy(kCellM);
  free_space.ForEachBlock(
      [&](LeafOrigin origin, const FreeBlock& block) { copy.StoreBlock(origin, block); });
  EXPECT_EQ(copy, free_space);
}

TEST(FreeSpace, LeavesCopiesAlone) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({0.05, 0.05, 0.05}, {2.0, 1.0, -1.0}, kRayTime, &changed);
  const FreeSpace copy = free_space;
  free_space.MarkRay({0.05, 0.35, 0.05}, {0.65, 0.35, 0.05}, kRayTime, &changed);
  EXPECT_TRUE(free_space.IsFree({0.25, 0.35, 0.05}));
  EXPECT_FALSE(copy.IsFree({0.25, 0.35, 0.05}));
  EXPECT_NE(copy, free_space);
}

TEST(FreeSpace, IsRecentWhereTheLatestSessionLooked) {
  FreeSpace free_space(kCellM);
  MarkAround(0.05, 100.0, 101.0, &free_space);
  MarkAround(0.25, 100.0, 102.0, &free_space);
  EXPECT_TRUE(free_space.IsFreeSince({0.05, 0.05, 0.05}, At(100.0)));
  EXPECT_FALSE(free_space.IsFreeSince({0.05, 0.05, 0.05}, At(100.5)));
  EXPECT_FALSE(free_space.IsFreeSince({0.15, 0.05, 0.05}, At(100.0)));
  // The next session looks through one of both cells.
  MarkAround(0.25, 200.0, 201.0, &free_space);
  EXPECT_FALSE(free_space.IsFreeSince({0.05, 0.05, 0.05}, At(100.0)));
  EXPECT_TRUE(free_space.IsFree({0.05, 0.05, 0.05}));
  EXPECT_TRUE(free_space.IsFreeSince({0.25, 0.05, 0.05}, At(200.0)));
}

TEST(FreeSpace, IsNotRecentWhereAnOlderRayPassed) {
  FreeSpace free_space(kCellM);
  MarkAround(0.05, 200.0, 201.0, &free_space);
  MarkAround(0.25, 100.0, 101.0, &free_space);
  EXPECT_TRUE(free_space.IsFreeSince({0.05, 0.05, 0.05}, At(200.0)));
  EXPECT_TRUE(free_space.IsFree({0.25, 0.05, 0.05}));
  EXPECT_FALSE(free_space.IsFreeSince({0.25, 0.05, 0.05}, At(100.0)));
}

TEST(FreeSpace, IsRecentWhereTwoSessionsLookAtOnce) {
  FreeSpace free_space(kCellM);
  MarkAround(0.05, 200.0, 201.0, &free_space);
  // Of a session that started earlier.
  MarkAround(0.25, 100.0, 202.0, &free_space);
  EXPECT_TRUE(free_space.IsFreeSince({0.05, 0.05, 0.05}, At(200.0)));
  EXPECT_TRUE(free_space.IsFreeSince({0.25, 0.05, 0.05}, At(200.0)));
}

TEST(FreeSpace, ALateFrameOfASessionHidesNothingThatIsRecent) {
  FreeSpace free_space(kCellM);
  MarkAround(0.05, 100.0, 101.0, &free_space);
  MarkAround(0.25, 200.0, 199.0, &free_space);
  EXPECT_TRUE(free_space.IsFreeSince({0.05, 0.05, 0.05}, At(100.0)));
  EXPECT_TRUE(free_space.IsFreeSince({0.25, 0.05, 0.05}, At(100.0)));
}

}  // namespace
}  // namespace steadymap
