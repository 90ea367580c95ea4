#include "core/change/changed_voxels.h"

#include <functional>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;

/// Returns a voxel at a distance from the surface. A voxel with a weight of zero is unobserved.
Voxel MakeVoxel(double distance_m, float weight = 1.0F) {
  return {testing::VoxelWithDistance(distance_m, kScale).distance_steps(),
          static_cast<int>(weight / kWeightUnit)};
}

/// Returns a volume of two leaves adjacent along x.
TsdfGrid VolumeOf(const std::function<Voxel(int x, int y, int z)>& voxel_at) {
  TsdfGrid grid;
  for (const int first : {0, kLeafSide}) {
    LeafVoxels voxels;
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      const Voxel voxel = voxel_at(first + static_cast<int>(offset >> 6),
                                   static_cast<int>(offset >> 3 & 7),
                                   static_cast<int>(offset & 7));
      voxels.voxels[offset] = voxel;
      if (voxel.weight_units() > 0) SetBit(offset, &voxels.observed);
    }
    grid.StoreLeaf({first, 0, 0}, voxels);
  }
  return grid;
}

/// Returns the changes if a block of voxels, [low, high), becomes free.
std::vector<VoxelChange> FreedIn(const Eigen::Vector3i& low,
                                 const Eigen::Vector3i& high,
                                 float weight = 1.0F) {
  const TsdfGrid before = VolumeOf([](int, int, int) { return MakeVoxel(0.0, 1.0); });
  const TsdfGrid after = VolumeOf([&](int x, int y, int z) {
    const Eigen::Vector3i voxel(x, y, z);
    const bool inside =
        (voxel.array() >= low.array()).all() && (voxel.array() < high.array()).all();
    return inside ? MakeVoxel(0.15, weight) : MakeVoxel(0.0, 1.0);
  });
  return FindChanges(before, after, {{0, 0, 0}, {8, 0, 0}}, kScale, {});
}

TEST(FindChanges, FindsABlockAcrossTwoLeaves) {
  const std::vector<VoxelChange> changes = FreedIn({5, 2, 3}, {11, 5, 5});
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].voxels, 36U);
  EXPECT_EQ(changes[0].freed, 36U);
  EXPECT_EQ(changes[0].taken, 0U);
  EXPECT_EQ(changes[0].leaves.size(), 2U);
  EXPECT_TRUE(changes[0].mean_voxel.isApprox(Eigen::Vector3d(7.5, 3.0, 3.5)));
}

TEST(FindChanges, LeavesOutWhatIsTooSmall) {
  EXPECT_TRUE(FreedIn({1, 1, 1}, {4, 4, 4}).empty()) << "27 voxels";
  EXPECT_EQ(FreedIn({1, 1, 1}, {4, 4, 5}).size(), 1U) << "36 voxels";
}

TEST(FindChanges, LeavesOutWhatIsOneVoxelThick) {
  EXPECT_TRUE(FreedIn({1, 1, 3}, {8, 8, 4}).empty());
  EXPECT_TRUE(FreedIn({3, 1, 1}, {4, 8, 8}).empty());
}

TEST(FindChanges, ComparesOnlyWhatWeighsEnough) {
  EXPECT_TRUE(FreedIn({1, 1, 1}, {5, 5, 5}, 0.25F).empty());
  EXPECT_EQ(FreedIn({1, 1, 1}, {5, 5, 5}, 0.35F).size(), 1U);
}

TEST(FindChanges, TellsWhatWasTakenFromWhatWasFreed) {
  const TsdfGrid before = VolumeOf([](int, int, int) { return MakeVoxel(0.1, 1.0); });
  const TsdfGrid after = VolumeOf([](int, int, int) { return MakeVoxel(0.0, 1.0); });
  const std::vector<VoxelChange> changes = FindChanges(before, after, {{0, 0, 0}}, kScale, {});
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].taken, 512U);
  EXPECT_EQ(changes[0].freed, 0U);
}

TEST(FindChanges, TakesDifferencesBelowHalfTheTruncationForNoise) {
  const TsdfGrid before = VolumeOf([](int, int, int) { return MakeVoxel(0.07, 1.0); });
  const TsdfGrid after = VolumeOf([](int, int, int) { return MakeVoxel(0.0, 1.0); });
  EXPECT_TRUE(FindChanges(before, after, {{0, 0, 0}, {8, 0, 0}}, kScale, {}).empty());
}

TEST(FindChanges, ConnectsVoxelsThatShareNoMoreThanACorner) {
  const TsdfGrid before = VolumeOf([](int, int, int) { return MakeVoxel(0.0, 1.0); });
  const TsdfGrid after = VolumeOf([](int x, int y, int z) {
    const bool low = x < 3 && y < 3 && z < 3;
    const bool high = x >= 3 && x < 6 && y >= 3 && y < 6 && z >= 3 && z < 6;
    return MakeVoxel(low || high ? 0.15 : 0.0, 1.0);
  });
  const std::vector<VoxelChange> changes = FindChanges(before, after, {{0, 0, 0}}, kScale, {});
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].voxels, 54U);
}

TEST(FindChanges, KnowsNoChangeWhereOneVolumeHasNoLeaf) {
  const TsdfGrid before = VolumeOf([](int, int, int) { return MakeVoxel(0.0, 1.0); });
  const TsdfGrid after;
  EXPECT_TRUE(FindChanges(before, after, {{0, 0, 0}, {8, 0, 0}}, kScale, {}).empty());
  EXPECT_TRUE(FindChanges(after, before, {}, kScale, {}).empty());
}

}  // namespace
}  // namespace steadymap
