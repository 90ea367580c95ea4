// Points of a floor, a wall and what stands beside them, in the grid of voxels.

#include "core/objects/scene_structure.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"

namespace steadymap {
namespace {

constexpr double kSceneVoxelM = 0.05;
constexpr int kSceneSideVoxels = 30;  // Of floor and wall: 2.25 square metres.

class SceneStructureTest : public ::testing::Test {
 protected:
  /// Adds the floor, from the origin along x and y, and the wall at x = 0.
  SceneStructureTest() {
    for (int i = 1; i <= kSceneSideVoxels; ++i) {
      for (int j = 0; j < kSceneSideVoxels; ++j) {
        Add({i, j, 0}, Eigen::Vector3d::UnitZ());
        Add({0, j, i}, Eigen::Vector3d::UnitX());
      }
    }
  }

  std::size_t Add(const Eigen::Vector3i& voxel, const Eigen::Vector3d& normal_world) {
    points_.push_back({kSceneVoxelM * voxel.cast<double>(), normal_world.normalized()});
    return points_.size() - 1;
  }

  std::vector<ScenePointKind> Find() const {
    const WorkingMap map{MapConfig()};
    return FindSceneStructure(SceneDivisionParameters(), SurfaceMatchParameters(), points_, map);
  }

  std::vector<OrientedPoint> points_;
};

TEST_F(SceneStructureTest, FloorAndWallAreStructure) {
  for (const ScenePointKind kind : Find()) EXPECT_EQ(kind, ScenePointKind::kStructure);
}

TEST_F(SceneStructureTest, TheEdgeBetweenFloorAndWallIsStructure) {
  std::vector<std::size_t> edge;
  edge.reserve(kSceneSideVoxels);
  for (int j = 0; j < kSceneSideVoxels; ++j) edge.push_back(Add({0, j, 0}, {1.0, 0.0, 1.0}));
  const std::vector<ScenePointKind> kinds = Find();
  for (const std::size_t i : edge) EXPECT_EQ(kinds[i], ScenePointKind::kStructure);
}

TEST_F(SceneStructureTest, WhatStandsOnTheFloorBlendsWithItAtItsFoot) {
  std::vector<std::size_t> side;
  for (int k = 1; k <= 6; ++k) side.push_back(Add({10, 10, k}, Eigen::Vector3d::UnitX()));
  const std::vector<ScenePointKind> kinds = Find();
  EXPECT_EQ(kinds[side[0]], ScenePointKind::kFoot);
  for (std::size_t k = 1; k < side.size(); ++k) EXPECT_EQ(kinds[side[k]], ScenePointKind::kThing);
}

TEST_F(SceneStructureTest, AThingAtAWallHasNoFootThere) {
  const std::size_t side = Add({1, 10, 10}, Eigen::Vector3d::UnitY());
  EXPECT_EQ(Find()[side], ScenePointKind::kThing);
}

TEST_F(SceneStructureTest, AThingBesideAnEdgeIsNoStructure) {
  // Its normals point away from the corner.
  const std::size_t corner = Add({1, 10, 1}, {-1.0, 0.0, -1.0});
  EXPECT_EQ(Find()[corner], ScenePointKind::kFoot);
}

TEST_F(SceneStructureTest, ASmallPlaneIsNoStructure) {
  std::vector<std::size_t> board;
  board.reserve(100);
  for (int i = 0; i < 100; ++i) {
    board.push_back(Add({10 + i / 10, 10 + i % 10, 15}, Eigen::Vector3d::UnitZ()));
  }
  const std::vector<ScenePointKind> kinds = Find();
  for (const std::size_t i : board) EXPECT_EQ(kinds[i], ScenePointKind::kThing);
}

}  // namespace
}  // namespace steadymap
