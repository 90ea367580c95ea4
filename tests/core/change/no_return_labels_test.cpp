#include "core/change/no_return_labels.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kPersonClass;
using ::steadymap::testing::kWallClass;

constexpr std::uint16_t kDistantCeiling = 2;

/// Returns a frame of five by five tiles without returns, with one label.
Frame NothingBut(std::uint16_t label) {
  constexpr int kFrameSidePx = 5 * MinDepthGrid::kTilePx;
  Frame frame;
  frame.depth.units = Image<std::uint16_t>(kFrameSidePx, kFrameSidePx, kNoDepth);
  frame.labels = Image<std::uint16_t>(kFrameSidePx, kFrameSidePx, label);
  return frame;
}

/// Whether the centre of a frame shows a distant class other than `class_id`.
bool MiddleIsFar(const Frame& frame, std::uint16_t class_id = kGoodsClass) {
  NoReturnLabels tiles{MapConfig()};
  tiles.Compute(frame);
  return tiles.ShowOther(ClassId(class_id), 2, 2);
}

TEST(NoReturnLabels, ShowWhatStaysWhereNothingReturns) {
  EXPECT_TRUE(MiddleIsFar(NothingBut(kWallClass)));
  Frame invalid = NothingBut(kWallClass);
  invalid.depth.units.At(9, 9) = kInvalidDepth;
  EXPECT_TRUE(MiddleIsFar(invalid));
  Frame corner = NothingBut(kWallClass);
  for (int u = 0; u < 10; ++u) corner.labels.At(u, 9) = kDistantCeiling;
  EXPECT_TRUE(MiddleIsFar(corner)) << "where two meet";
}

TEST(NoReturnLabels, ShowNothingOfTheClassThatWasAskedFor) {
  EXPECT_FALSE(MiddleIsFar(NothingBut(kWallClass), kWallClass)) << "glare keeps its label";
  Frame beside = NothingBut(kWallClass);
  beside.labels.At(15, 9) = kGoodsClass;
  EXPECT_FALSE(MiddleIsFar(beside)) << "in a neighbour";
  beside.labels.At(15, 9) = kWallClass;
  beside.labels.At(16, 9) = kGoodsClass;
  EXPECT_TRUE(MiddleIsFar(beside)) << "further off";
}

TEST(NoReturnLabels, ShowNothingWhereAnythingReturns) {
  Frame frame = NothingBut(kWallClass);
  frame.depth.units.At(4, 15) = 2000;
  EXPECT_FALSE(MiddleIsFar(frame));
  frame.depth.units.At(4, 15) = kNoDepth;
  frame.depth.units.At(4, 16) = 2000;
  EXPECT_TRUE(MiddleIsFar(frame)) << "further off";
}

TEST(NoReturnLabels, ShowNothingThatMayBeNear) {
  EXPECT_FALSE(MiddleIsFar(NothingBut(kPersonClass)));
  EXPECT_FALSE(MiddleIsFar(NothingBut(kGoodsClass), kWallClass)) << "may have been put there";
  EXPECT_FALSE(MiddleIsFar(NothingBut(0))) << "unlabelled";
  Frame without = NothingBut(kWallClass);
  without.labels = {};
  EXPECT_FALSE(MiddleIsFar(without));
}

TEST(NoReturnLabels, ShowNothingAtTheBorder) {
  NoReturnLabels tiles{MapConfig()};
  EXPECT_FALSE(tiles.ShowOther(ClassId(kGoodsClass), 2, 2)) << "no frame yet";
  const Frame frame = NothingBut(kWallClass);
  tiles.Compute(frame);
  EXPECT_TRUE(tiles.ShowOther(ClassId(kGoodsClass), 1, 3));
  for (const int place : {-1, 0, 4, 5, 700}) {
    EXPECT_FALSE(tiles.ShowOther(ClassId(kGoodsClass), place, 2));
    EXPECT_FALSE(tiles.ShowOther(ClassId(kGoodsClass), 2, place));
  }
}

}  // namespace
}  // namespace steadymap
