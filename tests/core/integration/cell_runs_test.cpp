#include "core/integration/cell_runs.h"

#include <random>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;

using Cell = std::pair<int, int>;  // Row and column.

/// Returns the cells of a wall. Owner and weight are each redrawn at a cell with probability
/// `change_chance`, else copied from the previous cell.
SemanticCloud RandomOwners(std::uint32_t owners, double change_chance, std::uint32_t seed) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(RenderScene({Body(kWallClass, {2.0, -4.0, -4.0}, {2.3, 4.0, 4.0})}, {}));
  std::mt19937 random(seed);
  std::bernoulli_distribution changes(change_chance);
  std::uint32_t owner = 0;
  float weight = 1.0F;
  for (int row = 0; row < cloud.cells_high(); ++row) {
    for (int column = 0; column < cloud.cells_wide(); ++column) {
      if (changes(random)) owner = static_cast<std::uint32_t>(random() % owners);
      if (changes(random)) weight = random() % 3 == 0 ? 0.0F : 1.0F;
      cloud.MutableAt(column, row).owner = owner;
      cloud.MutableAt(column, row).weight = weight;
    }
  }
  return cloud;
}

std::vector<Cell> CellsOf(const SemanticCloud& cloud, std::uint32_t owner) {
  std::vector<Cell> cells;
  for (int row = 0; row < cloud.cells_high(); ++row) {
    for (int column = 0; column < cloud.cells_wide(); ++column) {
      const SurfaceCell& cell = cloud.At(column, row);
      if (cell.weight > 0.0F && cell.owner == owner) cells.emplace_back(row, column);
    }
  }
  return cells;
}

std::vector<Cell> CellsOf(std::span<const CellRun> runs) {
  std::vector<Cell> cells;
  for (const CellRun& run : runs) {
    for (int column = run.begin; column < run.end; ++column) cells.emplace_back(run.row, column);
  }
  return cells;
}

TEST(CellRuns, HoldTheCellsOfEachOwnerOnceInOrder) {
  CellRuns runs;
  for (const std::uint32_t owners : {1U, 3U, 400U}) {
    for (const double change_chance : {0.01, 0.3, 1.0}) {
      const SemanticCloud cloud = RandomOwners(owners, change_chance, owners);
      runs.Compute(cloud);
      for (std::uint32_t owner = 0; owner <= owners; ++owner) {
        EXPECT_EQ(CellsOf(runs.Of(owner)), CellsOf(cloud, owner)) << owner << " of " << owners;
      }
    }
  }
}

TEST(CellRuns, AreNoneOfAnOwnerWithoutCells) {
  CellRuns runs;
  EXPECT_TRUE(runs.Of(0).empty());
  runs.Compute(RandomOwners(2, 0.5, 1));
  EXPECT_TRUE(runs.Of(2).empty());
  EXPECT_TRUE(runs.Of(0xFFFFFFFFU).empty());
}

}  // namespace
}  // namespace steadymap
