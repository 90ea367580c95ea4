// The two compiled variants of the kernels must produce bit-identical results for any input.

#include "core/integration/tsdf_kernel.h"

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr KernelNoise kNoise = {0.001F, 0.0025F};

/// Returns a depth image of slanted patches, edges, holes and noise.
std::vector<std::uint16_t> RandomDepth(int width_px, int height_px, std::mt19937* random) {
  std::vector<std::uint16_t> depth(static_cast<std::size_t>(width_px) *
                                   static_cast<std::size_t>(height_px));
  std::uniform_int_distribution<int> any(0, 65535);
  std::uniform_int_distribution<int> noise(-6, 6);
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      const int patch = (u / 23) * 7 + (v / 17) * 3;
      int value = 700 + 150 * (patch % 9) + 2 * u - v + noise(*random);
      if (any(*random) < 2000) value = any(*random);
      if (any(*random) < 2000) value = any(*random) % 2 == 0 ? 0 : 65535;
      const int index = v * width_px + u;
      depth[static_cast<std::size_t>(index)] = static_cast<std::uint16_t>(value);
    }
  }
  return depth;
}

struct Surface {
  std::vector<float> inverse_depth;
  std::vector<float> support;
  std::vector<SurfaceCell> cells;
  std::vector<std::uint8_t> clearance;
  std::vector<std::uint8_t> has_plane;
};

Surface ComputeSurface(const TsdfKernels& kernels, const SurfaceInput& input) {
  const int cells_wide = input.width_px / 2;
  const int cells_high = input.height_px / 2;
  const std::size_t padded = static_cast<std::size_t>(SurfaceStride(cells_wide)) *
                             static_cast<std::size_t>(cells_high + 2 * kSurfaceMarginRows);
  Surface surface{std::vector<float>(padded),
                  std::vector<float>(padded),
                  std::vector<SurfaceCell>(static_cast<std::size_t>(cells_wide) *
                                           static_cast<std::size_t>(cells_high)),
                  std::vector<std::uint8_t>(static_cast<std::size_t>(cells_wide) *
                                            static_cast<std::size_t>(cells_high)),
                  std::vector<std::uint8_t>(static_cast<std::size_t>(cells_wide) *
                                            static_cast<std::size_t>(cells_high))};
  kernels.compute_surface(input,
                          {surface.inverse_depth.data(),
                           surface.support.data(),
                           surface.cells.data(),
                           surface.clearance.data(),
                           surface.has_plane.data()});
  return surface;
}

SurfaceInput InputFor(const std::vector<std::uint16_t>& depth, int width_px, int height_px) {
  return {
      depth.data(), width_px, height_px, 0.001F, 3.0F, 0.15F, kNoise, 120.0F, 121.0F, 30.0F, 20.0F};
}

LeafKernelFrame FrameFor(const Surface& surface, int cells_wide, int cells_high) {
  return {surface.cells.data(),
          surface.clearance.data(),
          cells_wide,
          cells_high,
          120.0F,
          121.0F,
          30.0F,
          20.0F,
          {0.03F, 0.0F, 0.04F},
          {0.0F, 0.05F, 0.0F},
          {-0.04F, 0.0F, 0.03F},
          0.05F,
          0.15F,
          0.15F / static_cast<float>(kMaxDistanceSteps),
          kNoise,
          0,
          true,
          true};
}

TEST(TsdfKernels, VariantsFindTheSameSurface) {
  const TsdfKernels* const avx2_kernels = FindAvx2Kernels();
  if (avx2_kernels == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  std::mt19937 random(1);
  for (const auto& [width_px, height_px] :
       {std::pair{128, 96}, {129, 97}, {2, 2}, {3, 5}, {17, 33}, {62, 40}}) {
    const std::vector<std::uint16_t> depth = RandomDepth(width_px, height_px, &random);
    const SurfaceInput input = InputFor(depth, width_px, height_px);
    const Surface baseline = ComputeSurface(BaselineKernels(), input);
    const Surface avx2 = ComputeSurface(*avx2_kernels, input);
    EXPECT_EQ(
        0,
        std::memcmp(
            baseline.cells.data(), avx2.cells.data(), baseline.cells.size() * sizeof(SurfaceCell)))
        << width_px << " x " << height_px;
    EXPECT_EQ(baseline.has_plane, avx2.has_plane) << width_px << " x " << height_px;
    EXPECT_EQ(baseline.clearance, avx2.clearance) << width_px << " x " << height_px;
  }
}

TEST(TsdfKernels, VariantsWriteTheSameVoxels) {
  const TsdfKernels* const avx2_kernels = FindAvx2Kernels();
  if (avx2_kernels == nullptr) GTEST_SKIP() << "this processor has no AVX2";
  std::mt19937 random(2);
  constexpr int kWidthPx = 128;
  constexpr int kHeightPx = 96;
  const std::vector<std::uint16_t> depth = RandomDepth(kWidthPx, kHeightPx, &random);
  Surface surface = ComputeSurface(BaselineKernels(), InputFor(depth, kWidthPx, kHeightPx));
  for (SurfaceCell& cell : surface.cells) {
    cell.color = static_cast<std::uint32_t>(random()) | 0xFF000000U;
  }
  const LeafKernelFrame frame = FrameFor(surface, kWidthPx / 2, kHeightPx / 2);
  std::uniform_real_distribution<float> place(-1.0F, 1.0F);
  int leaves_changed = 0;
  for (int round = 0; round < 300; ++round) {
    LeafVoxels voxels[2];
    bool changed[2] = {false, false};
    const float origin[3] = {place(random), place(random), 1.2F + place(random)};
    // Several observations, so that averaging, settling and the weight cap all take effect.
    for (int look = 0; look < 40; ++look) {
      for (const int variant : {0, 1}) {
        LeafVoxels& leaf = voxels[variant];
        const LeafKernelLeaf kernel_leaf{
            {origin[0], origin[1], origin[2] + 0.001F * static_cast<float>(look)},
            &leaf.voxels.data()->bits,
            leaf.color.data(),
            leaf.observed.data()};
        const TsdfKernels& kernels = variant == 0 ? BaselineKernels() : *avx2_kernels;
        changed[variant] = kernels.update_leaf(frame, kernel_leaf);
      }
      ASSERT_EQ(changed[0], changed[1]);
      ASSERT_EQ(voxels[0], voxels[1]);
    }
    if (voxels[0].observed != LeafMask{}) ++leaves_changed;
  }
  EXPECT_GT(leaves_changed, 50);
}

TEST(TsdfKernels, VoxelsStayInRange) {
  std::mt19937 random(3);
  constexpr int kWidthPx = 128;
  constexpr int kHeightPx = 96;
  const std::vector<std::uint16_t> depth = RandomDepth(kWidthPx, kHeightPx, &random);
  const Surface surface = ComputeSurface(SelectKernels(), InputFor(depth, kWidthPx, kHeightPx));
  const LeafKernelFrame frame = FrameFor(surface, kWidthPx / 2, kHeightPx / 2);
  LeafVoxels leaf;
  for (int look = 0; look < 500; ++look) {
    SelectKernels().update_leaf(
        frame, {{-0.2F, -0.2F, 1.0F}, &leaf.voxels.data()->bits, nullptr, leaf.observed.data()});
  }
  ASSERT_NE(leaf.observed, LeafMask{});
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    ASSERT_LE(std::abs(leaf.voxels[offset].distance_steps()), kMaxDistanceSteps);
    ASSERT_EQ(IsSet(leaf.observed, offset), leaf.voxels[offset].weight_units() > 0);
  }
}

}  // namespace
}  // namespace steadymap
