// Upright surfaces that face the camera, against the direction of y, and the free space around
// them.

#include "core/objects/outline.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/objects/surface_parts.h"
#include "core/types/map_config.h"
#include "core/working/working_map.h"

namespace steadymap {
namespace {

constexpr double kUprightSpacingM = 0.05;  // Also of rays.
constexpr double kSurfaceY = 1.0;          // Metres.

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
        map_.MarkFree(low, {low.x(), low.y(), bounds_world.max().z()});
      }
    }
  }

  bool GoesOnAsRight(double max_gap_m) const {
    return OutlineTest(map_, {}).MayGoOnAs(
        UprightBetween(0.0, 0.3), UprightBetween(0.5, 0.8), max_gap_m);
  }

  WorkingMap map_{MapConfig()};
};

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

TEST_F(OutlineTestTest, APostHasAnUnseenEndUnlessTheSpaceBeyondIsFree) {
  const std::vector<OrientedPoint> post = UprightBetween(0.0, 0.05);
  EXPECT_TRUE(OutlineTest(map_, {}).HasUnseenEnd(post, {}));
  MarkFree(Box(Eigen::Vector3d(-0.2, 0.8, 0.55), Eigen::Vector3d(0.2, 1.2, 0.8)));
  const std::vector<Eigen::Vector3d> floor = {{0.0, kSurfaceY, -0.05}, {0.05, kSurfaceY, -0.05}};
  EXPECT_FALSE(OutlineTest(map_, floor).HasUnseenEnd(post, {}));
  const std::vector<Eigen::Vector3d> board = {{0.0, kSurfaceY, 0.55}, {0.05, kSurfaceY, 0.55}};
  EXPECT_TRUE(OutlineTest(map_, floor).HasUnseenEnd(post, board));
}

}  // namespace
}  // namespace steadymap
