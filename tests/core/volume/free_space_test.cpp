#include "core/volume/free_space.h"

#include <bit>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr double kCellM = 0.1;

std::size_t CountFreeCells(const FreeSpace& free_space) {
  std::size_t count = 0;
  free_space.ForEachBlock([&](LeafOrigin, const LeafMask& cells) {
    for (const std::uint64_t word : cells) count += static_cast<std::size_t>(std::popcount(word));
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
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.45, 0.05, 0.05}, &changed);
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
  free_space.MarkRay(from, to, &changed);
  EXPECT_TRUE(free_space.IsFree(from));
  const Eigen::Vector3d direction = (to - from).normalized();
  free_space.ForEachBlock([&](LeafOrigin origin, const LeafMask& cells) {
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (!IsSet(cells, offset)) continue;
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
  free_space.MarkRay({0.05, 0.05, 0.05}, {0.05, 0.05, 0.05}, &changed);
  EXPECT_EQ(CountFreeCells(free_space), 1U);
  EXPECT_TRUE(free_space.IsFree({0.05, 0.05, 0.05}));
}

TEST(FreeSpace, ReportsEachBlockThatChangedAndNoneThatDidNot) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.45, 0.05, 0.05}, &changed);
  EXPECT_EQ(changed, (std::vector<LeafOrigin>{{-8, 0, 0}, {0, 0, 0}}));
  changed.clear();
  const FreeSpace before = free_space;
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.45, 0.05, 0.05}, &changed);
  EXPECT_TRUE(changed.empty());
  EXPECT_EQ(free_space, before);
  free_space.MarkRay({-0.55, 0.05, 0.05}, {0.65, 0.05, 0.05}, &changed);
  EXPECT_EQ(changed, (std::vector<LeafOrigin>{{0, 0, 0}}));
}

TEST(FreeSpace, IsWhatItsBlocksSay) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({0.05, 0.05, 0.05}, {2.0, 1.0, -1.0}, &changed);
  FreeSpace copy(kCellM);
  free_space.ForEachBlock(
      [&](LeafOrigin origin, const LeafMask& cells) { copy.StoreBlock(origin, cells); });
  EXPECT_EQ(copy, free_space);
}

TEST(FreeSpace, LeavesCopiesAlone) {
  FreeSpace free_space(kCellM);
  std::vector<LeafOrigin> changed;
  free_space.MarkRay({0.05, 0.05, 0.05}, {2.0, 1.0, -1.0}, &changed);
  const FreeSpace copy = free_space;
  free_space.MarkRay({0.05, 0.35, 0.05}, {0.65, 0.35, 0.05}, &changed);
  EXPECT_TRUE(free_space.IsFree({0.25, 0.35, 0.05}));
  EXPECT_FALSE(copy.IsFree({0.25, 0.35, 0.05}));
  EXPECT_NE(copy, free_space);
}

}  // namespace
}  // namespace steadymap
