// The cost of one frame is bounded for all frames and maps that pass validation.

#include "tests/support/legal_frame.h"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

#include "core/integration/frame_work.h"
#include "core/mapper.h"

namespace steadymap {
namespace {

/// Integrates a frame into an empty map, and again from a pose 2 cm further. Returns the larger
/// number of leaves that one integration changed.
std::size_t MostLeavesChanged(const MapConfig& config, Frame frame) {
  auto mapper = Mapper::Create(config).value();
  std::size_t most = 0;
  for (int i = 1; i <= 2; ++i) {
    frame.capture_time = Timestamp::FromSeconds(0.1 * i);
    mapper->Integrate(mapper->head().Next(), frame);
    most = std::max(most, mapper->Commit().delta.leaves.size());
    frame.T_world_camera.translate(Eigen::Vector3d(0.02, 0.0, 0.0));
  }
  return most;
}

TEST(LegalFrame, IsRefusedOrTouchesABoundedNumberOfLeaves) {
  constexpr std::uint64_t kFrames = 60;
  constexpr int kMaxSidePx = 320;
  std::uint64_t taken = 0;
  for (std::uint64_t seed = 0; seed < kFrames; ++seed) {
    const LegalFrame legal = RandomLegalFrame(seed, kMaxSidePx);
    SCOPED_TRACE(legal.description);
    ASSERT_TRUE(ValidateMapConfig(legal.config).ok());
    ASSERT_TRUE(ValidateFrame(legal.frame, KnownLabels(legal.config.classes)).ok());
    if (!CheckFrameWork(legal.frame, legal.config).ok()) continue;
    EXPECT_LE(MostLeavesChanged(legal.config, legal.frame), kMaxFusedLeaves);
    ++taken;
  }
  EXPECT_GT(taken, kFrames / 4);
  EXPECT_LT(taken, kFrames);
}

TEST(LegalFrame, OfThingsThatShareTheirLeavesIsFusedWithinTheBound) {
  // A thousand adjacent stripes of 5 mm by 25 m intersect about 15 000 leaves together, but each
  // stripe has its own volume with hundreds of leaves: 440 000 leaves and 4.7 GB without the bound.
  MapConfig config;
  config.policy = UpdatePolicy::kPocd;
  config.voxel_size_m = 0.025;
  config.truncation_m = 0.4;
  config.max_depth_m = 6.0;
  constexpr int kStripePx = 4;
  constexpr std::uint16_t kGoods = 7;
  Frame frame;
  frame.source = {"robot", "camera"};
  frame.camera = {4096, 1024, 4096.0, 205.0, 2048.0, 512.0};
  frame.depth.units = Image<std::uint16_t>(4096, 1024, 5000);
  frame.labels = Image<std::uint16_t>(4096, 1024, kGoods);
  frame.instances = Image<std::uint16_t>(4096, 1024);
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      frame.instances.At(u, v) = static_cast<std::uint16_t>(u / kStripePx + 1);
    }
  }
  ASSERT_TRUE(CheckFrameWork(frame, config).ok());
  EXPECT_LE(MostLeavesChanged(config, frame), kMaxFusedLeaves);
}

}  // namespace
}  // namespace steadymap
