// Upright surfaces that face the camera, against the direction of y, and the free space around
// them.

#include "core/objects/outline.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/objects/surface_parts.h"
#include "core/types/map_config.h"
#include "core/volume/voxel_leaf.h"
#include "core/working/working_map.h"

namespace steadymap {
namespace {

constexpr double kUprightSpacingM = 0.05;  // Also of rays.
constexpr double kSurfaceY = 1.0;          // Metres.

/// Points of the floor on which upright surfaces stand.
const std::vector<Eigen::Vector3d> kFloor = {{0.0, kSurfaceY, -0.05}, {0.05, kSurfaceY, -0.05}};

/// Returns an upright surface from the floor to a height of 50 cm.
std::vector<OrientedPoint> UprightBetween(double left_m, double right_m) {
  std::vector<OrientedPoint> points;
  const int columns = static_cast<int>(std::lround((right_m - left_m) / kUprightSpacingM));
  for (int column = 0; column <= columns; ++column) {
    for (int row = 0; row <= 10; ++row) {
      points.push_back({{left_m + column * kUprightSpacingM, kSurfaceY, row * kUprightSpacingM},
                        -Eigen::Vector3d::UnitY()});
    }
  }
  return points;
}

class OutlineTestTest : public ::testing::Test {
 protected:
  OutlineTestTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  void MarkFree(const Box& bounds_world) {
    const Eigen::Vector3d steps = bounds_world.sizes() / kUprightSpacingM;
    for (int i = 0; i <= static_cast<int>(steps.x()); ++i) {
      for (int j = 0; j <= static_cast<int>(steps.y()); ++j) {
        const Eigen::Vector3d low =
            bounds_world.min() + kUprightSpacingM * Eigen::Vector3d(static_cast<double>(i), j, 0.0);
        map_.MarkFree(low, {low.x(), low.y(), bounds_world.max().z()}, map_.now());
      }
    }
  }

  /// Stores voxels of one weight in the background around `point_world`.
  void StoreBackground(const Eigen::Vector3d& point_world, int weight_units) {
    MapSnapshot map = *map_.Commit().snapshot;
    const Eigen::Vector3i voxel =
        (point_world / map_.scale().voxel_size_m).array().round().cast<int>();
    const LeafOrigin origin = LeafOf(voxel.x(), voxel.y(), voxel.z());
    LeafVoxels voxels{};
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      voxels.voxels[offset] = Voxel(0, weight_units);
      SetBit(offset, &voxels.observed);
    }
    map.background.MutableTile(origin).StoreLeaf(origin, voxels);
    map_.Restore(map);
  }

  bool GoesOnAsRight(double max_gap_m) const {
    return OutlineTest(map_, {}).MayGoOnAs(
        UprightBetween(0.0, 0.3), UprightBetween(0.5, 0.8), max_gap_m);
  }

  WorkingMap map_{MapConfig()};
};

TEST_F(OutlineTestTest, AFlatSurfaceInUnknownSpaceWasNotSeenToEnd) {
  EXPECT_GT(OutlineTest(map_, {}).UnseenShareOf(UprightBetween(0.0, 0.5)), 0.9);
}

TEST_F(OutlineTestTest, AFlatSurfaceInFreeSpaceWasSeenToEnd) {
  MarkFree(Box(Eigen::Vector3d(-0.4, 0.8, -0.4), Eigen::Vector3d(0.9, 1.2, 0.9)));
  EXPECT_LT(OutlineTest(map_, {}).UnseenShareOf(UprightBetween(0.0, 0.5)), 0.1);
}

TEST_F(OutlineTestTest, AThingCloselyBeforeAWallEndsThere) {
  const std::vector<OrientedPoint> side = UprightBetween(0.0, 0.5);
  std::vector<Eigen::Vector3d> floor_and_walls;
  for (int i = 0; i <= 10; ++i) {
    const double along_m = i * kUprightSpacingM;
    floor_and_walls.emplace_back(along_m, kSurfaceY, -0.15);
    floor_and_walls.emplace_back(-0.15, kSurfaceY, along_m);
    floor_and_walls.emplace_back(0.65, kSurfaceY, along_m);
  }
  const OutlineTest test(map_, floor_and_walls);
  EXPECT_GT(test.UnseenShareOf(side), 0.9) << "the upper edge was not seen";
  MarkFree(Box(Eigen::Vector3d(-0.4, 0.8, 0.55), Eigen::Vector3d(0.9, 1.2, 0.9)));
  EXPECT_LT(test.UnseenShareOf(side), 0.1);
}

TEST_F(OutlineTestTest, TheFreeShareIsThatOfAllOfTheOutline) {
  const std::vector<OrientedPoint> surface = UprightBetween(0.0, 0.5);
  EXPECT_EQ(OutlineTest(map_, {}).FreeShareOf({}), 0.0);
  EXPECT_EQ(OutlineTest(map_, {}).FreeShareOf(surface), 0.0);
  // One side of the square.
  MarkFree(Box(Eigen::Vector3d(0.55, 0.8, -0.4), Eigen::Vector3d(0.9, 1.2, 0.9)));
  EXPECT_NEAR(OutlineTest(map_, {}).FreeShareOf(surface), 0.25, 0.05);
}

TEST_F(OutlineTestTest, ASlantingEdgeOfAWallIsAPartOfItsOutline) {
  // A triangle on the floor, beside another wall: the camera did not see what is above.
  std::vector<OrientedPoint> wall = UprightBetween(0.0, 0.5);
  std::erase_if(wall, [](const OrientedPoint& point) {
    return point.position_world.z() > point.position_world.x() + 0.01;
  });
  std::vector<Eigen::Vector3d> floor_and_wall;
  for (int i = 0; i <= 10; ++i) {
    const double along_m = i * kUprightSpacingM;
    floor_and_wall.emplace_back(along_m, kSurfaceY, -0.05);
    floor_and_wall.emplace_back(0.55, kSurfaceY, along_m);
  }
  EXPECT_GT(OutlineTest(map_, floor_and_wall).UnseenShareOf(wall), 0.9);
}

TEST_F(OutlineTestTest, FreeSpaceAboveAFloorIsNotBesideIt) {
  std::vector<OrientedPoint> floor;
  for (int x = 0; x <= 10; ++x) {
    for (int y = 0; y <= 10; ++y) {
      floor.push_back({kUprightSpacingM * Eigen::Vector3d(x, y, 0.0), Eigen::Vector3d::UnitZ()});
    }
  }
  MarkFree(Box(Eigen::Vector3d(-0.4, -0.4, 0.02), Eigen::Vector3d(0.9, 0.9, 0.9)));
  EXPECT_EQ(OutlineTest(map_, {}).FreeShareOf(floor), 0.0);
  // The top of a table: space below it is free, too.
  MarkFree(Box(Eigen::Vector3d(-0.4, -0.4, -0.5), Eigen::Vector3d(0.9, 0.9, 0.9)));
  EXPECT_EQ(OutlineTest(map_, {}).FreeShareOf(floor), 1.0);
}

TEST_F(OutlineTestTest, AHoleInAClosedSurfaceIsASmallShareOfItsOutline) {
  // A sphere, of which a cap with a radius of 10 cm was not seen.
  std::vector<OrientedPoint> sphere;
  constexpr double kStepRad = 0.15;
  for (int ring = 2; ring * kStepRad < M_PI; ++ring) {
    const double polar = ring * kStepRad;
    const double around_rad = 2.0 * M_PI * std::sin(polar);
    const int count = std::max(1, static_cast<int>(around_rad / kStepRad));
    for (int i = 0; i < count; ++i) {
      const double azimuth = 2.0 * M_PI * i / count;
      const Eigen::Vector3d normal(std::sin(polar) * std::cos(azimuth),
                                   std::sin(polar) * std::sin(azimuth),
                                   std::cos(polar));
      sphere.push_back({0.333 * normal, normal});
    }
  }
  EXPECT_LT(OutlineTest(map_, {}).UnseenShareOf(sphere), 0.4);
}

TEST_F(OutlineTestTest, ASurfaceMayGoOnWhereNothingWasSeen) {
  EXPECT_TRUE(GoesOnAsRight(0.25));
  EXPECT_FALSE(GoesOnAsRight(0.15));
}

TEST_F(OutlineTestTest, ASurfaceEndsAtAGapThatWasSeenThrough) {
  MarkFree(Box(Eigen::Vector3d(0.35, 0.0, 0.0), Eigen::Vector3d(0.45, 2.0, 0.6)));
  EXPECT_FALSE(GoesOnAsRight(0.25));
}

TEST_F(OutlineTestTest, FreeSpaceInFrontTellsNothingOfWhatIsBehind) {
  // The cells at the surfaces reach up to 10 cm behind them.
  MarkFree(Box(Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.8, kSurfaceY + 0.01, 0.6)));
  EXPECT_TRUE(GoesOnAsRight(0.25));
}

TEST_F(OutlineTestTest, ASurfaceEndsWhereTheFloorBesideItWasSeen) {
  StoreBackground({0.4, kSurfaceY, 0.0}, 1);
  EXPECT_TRUE(GoesOnAsRight(0.25)) << "extrapolated";
  StoreBackground({0.4, kSurfaceY, 0.0}, 2);
  EXPECT_FALSE(GoesOnAsRight(0.25));
}

TEST_F(OutlineTestTest, APostHasAnUnseenEndUnlessTheSpaceBeyondIsFree) {
  const std::vector<OrientedPoint> post = UprightBetween(0.0, 0.05);
  EXPECT_TRUE(OutlineTest(map_, {}).HasUnseenEnd(post, {}));
  MarkFree(Box(Eigen::Vector3d(-0.2, 0.8, 0.55), Eigen::Vector3d(0.2, 1.2, 0.8)));
  EXPECT_FALSE(OutlineTest(map_, kFloor).HasUnseenEnd(post, {}));
  const std::vector<Eigen::Vector3d> board = {{0.0, kSurfaceY, 0.55}, {0.05, kSurfaceY, 0.55}};
  EXPECT_TRUE(OutlineTest(map_, kFloor).HasUnseenEnd(post, board));
}

TEST_F(OutlineTestTest, APostEndsAtMeasuredBackgroundAlone) {
  const std::vector<OrientedPoint> post = UprightBetween(0.0, 0.05);
  const Eigen::Vector3d beyond(0.05, kSurfaceY, 0.55);
  StoreBackground(beyond, 1);
  EXPECT_TRUE(OutlineTest(map_, kFloor).HasUnseenEnd(post, {})) << "extrapolated";
  StoreBackground(beyond, 2);
  EXPECT_FALSE(OutlineTest(map_, kFloor).HasUnseenEnd(post, {}));
}

TEST_F(OutlineTestTest, AnEndOfWhichHalfWasSeenIsUnseen) {
  MarkFree(Box(Eigen::Vector3d(-0.2, 0.8, 0.55), Eigen::Vector3d(0.2, 1.2, 0.8)));
  const std::vector<Eigen::Vector3d> board = {{-0.05, kSurfaceY, 0.55}};
  EXPECT_TRUE(OutlineTest(map_, kFloor).HasUnseenEnd(UprightBetween(0.0, 0.05), board));
  EXPECT_FALSE(OutlineTest(map_, kFloor).HasUnseenEnd(UprightBetween(0.0, 0.1), board));
}

TEST_F(OutlineTestTest, APostGoesOnAsNothingBesideIt) {
  MarkFree(Box(Eigen::Vector3d(-0.2, 0.8, 0.55), Eigen::Vector3d(0.2, 1.2, 0.8)));
  const std::vector<Eigen::Vector3d> side = {{0.0, kSurfaceY + 0.05, 0.5},
                                             {0.05, kSurfaceY + 0.05, 0.5}};
  EXPECT_FALSE(OutlineTest(map_, kFloor).HasUnseenEnd(UprightBetween(0.0, 0.05), side));
}

}  // namespace
}  // namespace steadymap
