#include "core/volume/leaf_patch.h"

#include <random>

#include <gtest/gtest.h>

#include "core/volume/tsdf_codec.h"
#include "tests/core/volume/random_leaf.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;

std::size_t CountVoxels(const LeafMask& mask) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) count += IsSet(mask, i) ? 1 : 0;
  return count;
}

/// Returns a copy of `leaf` with random voxels replaced and random voxels added.
LeafVoxels Later(const LeafVoxels& leaf, std::mt19937* random) {
  const LeafVoxels other = RandomLeaf(random, 0.3, /*smooth=*/true, leaf.has_color);
  LeafVoxels later = leaf;
  ApplyLeafPatch(other, &later);
  return later;
}

TEST(LeafPatch, TakesALeafToWhatItBecame) {
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    const LeafVoxels before = RandomLeaf(&random, 0.4, true, /*color=*/i % 2 == 0);
    const LeafVoxels after = Later(before, &random);
    const auto patch = FindLeafPatch(ViewOf(before), ViewOf(after));
    ASSERT_TRUE(patch.has_value());
    for (std::size_t k = 0; k < kLeafVoxels; ++k) {
      const bool same = IsSet(before.observed, k) == IsSet(after.observed, k) &&
                        before.voxels[k] == after.voxels[k] && before.color[k] == after.color[k];
      ASSERT_EQ(IsSet(patch->observed, k), !same) << k;
    }
    LeafVoxels sent;
    ASSERT_TRUE(UnpackLeaf(PackLeaf(*patch), &sent).ok());
    LeafVoxels leaf = before;
    ApplyLeafPatch(sent, &leaf);
    ASSERT_EQ(leaf, after);
    ApplyLeafPatch(sent, &leaf);
    ASSERT_EQ(leaf, after) << "twice does no harm";
  }
}

TEST(LeafPatch, OfEqualLeavesIsEmpty) {
  std::mt19937 random(4);
  for (const bool color : {false, true}) {
    const LeafVoxels leaf = RandomLeaf(&random, 0.5, false, color);
    const auto patch = FindLeafPatch(ViewOf(leaf), ViewOf(leaf));
    ASSERT_TRUE(patch.has_value());
    EXPECT_EQ(CountVoxels(patch->observed), 0U);
  }
}

TEST(LeafPatch, ColoursAloneAreAChange) {
  std::mt19937 random(5);
  const LeafVoxels before = RandomLeaf(&random, 0.5, true, true);
  LeafVoxels after = before;
  std::size_t observed = 0;
  while (!IsSet(before.observed, observed)) ++observed;
  after.color[observed] ^= 1U;
  const auto patch = FindLeafPatch(ViewOf(before), ViewOf(after));
  ASSERT_TRUE(patch.has_value());
  EXPECT_EQ(CountVoxels(patch->observed), 1U);
  EXPECT_TRUE(IsSet(patch->observed, observed));
}

TEST(LeafPatch, TheFirstColoursConcernTheWholeLeaf) {
  std::mt19937 random(6);
  const LeafVoxels after = RandomLeaf(&random, 0.5, true, true);
  LeafVoxels before = after;
  before.has_color = false;
  before.color.fill(0);
  const auto patch = FindLeafPatch(ViewOf(before), ViewOf(after));
  ASSERT_TRUE(patch.has_value());
  LeafVoxels sent;
  ASSERT_TRUE(UnpackLeaf(PackLeaf(*patch), &sent).ok());
  ApplyLeafPatch(sent, &before);
  EXPECT_EQ(before, after);
}

TEST(LeafPatch, CannotTellThatSomethingIsGone) {
  std::mt19937 random(7);
  const LeafVoxels leaf = RandomLeaf(&random, 0.5, true, true);
  LeafVoxels less = leaf;
  std::size_t word = 0;
  while (less.observed[word] == 0) ++word;
  less.observed[word] &= less.observed[word] - 1;
  EXPECT_FALSE(FindLeafPatch(ViewOf(leaf), ViewOf(less)).has_value());
  EXPECT_TRUE(FindLeafPatch(ViewOf(less), ViewOf(leaf)).has_value());
  LeafVoxels colorless = leaf;
  colorless.has_color = false;
  EXPECT_FALSE(FindLeafPatch(ViewOf(leaf), ViewOf(colorless)).has_value());
  EXPECT_FALSE(FindLeafPatch(LeafView(), ViewOf(leaf)).has_value());
  EXPECT_FALSE(FindLeafPatch(ViewOf(leaf), LeafView()).has_value());
}

}  // namespace
}  // namespace steadymap
