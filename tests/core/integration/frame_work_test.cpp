#include "core/integration/frame_work.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

MapConfig FineConfig(double voxel_size_m, double max_depth_m) {
  MapConfig config;
  config.voxel_size_m = voxel_size_m;
  config.truncation_m = 3.0 * voxel_size_m;
  config.max_depth_m = max_depth_m;
  return config;
}

/// Returns a frame of a wall at `depth_m`, perpendicular to a camera of 90 by 90 degrees.
Frame Wall(int side_px, double depth_m) {
  Frame frame;
  frame.camera = {side_px, side_px, side_px / 2.0, side_px / 2.0, side_px / 2.0, side_px / 2.0};
  frame.depth.units =
      Image<std::uint16_t>(side_px, side_px, static_cast<std::uint16_t>(depth_m * 1000.0));
  return frame;
}

/// Returns a frame with an independent random depth at each pixel.
Frame Noise(int side_px, double max_depth_m) {
  Frame frame = Wall(side_px, 1.0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> depth_m(0.1, max_depth_m);
  for (std::size_t i = 0; i < frame.depth.units.size(); ++i) {
    frame.depth.units.data()[i] = static_cast<std::uint16_t>(1000.0 * depth_m(random));
  }
  return frame;
}

TEST(EstimateTouchedLeaves, AreThoseOfAWall) {
  // A wall of 4 m by 4 m has 2 500 leaves of 8 cm on its face. The truncation band of 12 cm
  // intersects two or three layers of leaves.
  const std::size_t leaves =
      EstimateTouchedLeaves(Wall(512, 2.0), FineConfig(0.01, 4.0), kMaxFrameLeaves);
  EXPECT_GT(leaves, 2 * 2400U);
  EXPECT_LT(leaves, 4 * 2700U);
}

TEST(EstimateTouchedLeaves, AreNoneWhereNothingIsFused) {
  EXPECT_EQ(EstimateTouchedLeaves(Wall(64, 5.0), FineConfig(0.01, 4.0), 100), 0U);
  Frame blind = Wall(64, 2.0);
  blind.depth.units = Image<std::uint16_t>(64, 64, kInvalidDepth);
  EXPECT_EQ(EstimateTouchedLeaves(blind, FineConfig(0.01, 4.0), 100), 0U);
}

TEST(CheckFrameWork, TakesWhatCamerasSee) {
  EXPECT_TRUE(CheckFrameWork(Wall(640, 3.0), MapConfig()).ok());
  EXPECT_TRUE(CheckFrameWork(Wall(640, 3.0), FineConfig(0.01, 10.0)).ok());
  EXPECT_TRUE(CheckFrameWork(Wall(640, 1.0), FineConfig(0.002, 2.0)).ok());
  EXPECT_TRUE(CheckFrameWork(Noise(512, 4.0), FineConfig(0.05, 4.0)).ok());
}

TEST(CheckFrameWork, RefusesWhatWouldFillTheMemory) {
  for (const Frame& frame : {Wall(1024, 2.0), Noise(512, 4.0)}) {
    const absl::Status status = CheckFrameWork(frame, FineConfig(0.001, 4.0));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(ReasonOf(status), reason::kFrameTooFine);
    EXPECT_EQ(FieldOf(status), "depth");
  }
}

}  // namespace
}  // namespace steadymap
