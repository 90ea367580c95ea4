#include "core/change/min_depth_grid.h"

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(MinDepthGrid, FindsTheNearestAroundATileThatWasMeasured) {
  DepthImage depth;
  depth.units = Image<std::uint16_t>(20, 20, 2000);
  depth.units.At(4, 4) = 900;  // In tile (1, 1).
  for (int v = 12; v < 16; ++v) {
    for (int u = 12; u < 15; ++u) depth.units.At(u, v) = u == 12 ? kInvalidDepth : kNoDepth;
  }
  MinDepthGrid tiles;
  tiles.Compute(depth);
  EXPECT_FLOAT_EQ(tiles.NearestAround(1, 1), 0.9F);
  EXPECT_FLOAT_EQ(tiles.NearestAround(2, 2), 0.9F);
  EXPECT_EQ(tiles.NearestAround(3, 1), 2.0F);
  EXPECT_EQ(tiles.NearestAround(3, 3), 0.0F) << "hardly measured";
  EXPECT_EQ(tiles.NearestAround(0, 2), 0.0F) << "at the border";
  EXPECT_EQ(tiles.NearestAround(4, 2), 0.0F);
  EXPECT_EQ(tiles.NearestAround(-1, 700), 0.0F);
}

TEST(MinDepthGrid, KnowsHowFarTheSensorMeasures) {
  DepthImage depth;
  depth.units = Image<std::uint16_t>(20, 20, kNoDepth);
  MinDepthGrid tiles;
  tiles.Compute(depth);
  EXPECT_EQ(tiles.farthest_m(), 0.0F);
  for (int v = 8; v < 12; ++v) {
    for (int u = 8; u < 12; ++u) depth.units.At(u, v) = 3000;
  }
  depth.units.At(9, 9) = 2500;
  depth.units.At(1, 1) = 900;
  depth.units.At(2, 1) = kInvalidDepth;
  tiles.Compute(depth);
  EXPECT_FLOAT_EQ(tiles.farthest_m(), 2.5F) << "of each tile, its nearest";
}

}  // namespace
}  // namespace steadymap
