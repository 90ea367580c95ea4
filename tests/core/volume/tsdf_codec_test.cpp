#include "core/volume/tsdf_codec.h"

#include <cmath>
#include <cstdint>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/core/volume/random_leaf.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;

TEST(PackLeaf, RoundTripsEveryBit) {
  std::mt19937 random(7);
  for (const double probability : {0.002, 0.1, 0.5, 0.97, 1.0}) {
    for (const bool smooth : {false, true}) {
      for (const bool color : {false, true}) {
        const LeafVoxels leaf = RandomLeaf(&random, probability, smooth, color);
        if (leaf.observed == LeafMask{}) continue;
        const std::string packed = PackLeaf(ViewOf(leaf));
        LeafVoxels unpacked;
        ASSERT_TRUE(UnpackLeaf(packed, &unpacked).ok());
        ASSERT_EQ(unpacked, leaf);
        EXPECT_EQ(PackLeaf(ViewOf(unpacked)), packed) << "packing must be canonical";
      }
    }
  }
}

TEST(PackLeaf, OfNothingIsNothing) {
  const LeafVoxels leaf;
  EXPECT_EQ(PackLeaf(ViewOf(leaf)), "");
  LeafVoxels unpacked;
  unpacked.observed[3] = 1;
  ASSERT_TRUE(UnpackLeaf("", &unpacked).ok());
  EXPECT_EQ(unpacked, LeafVoxels{});
}

TEST(PackLeaf, TakesThreeBytesAVoxelOfASmoothField) {
  std::mt19937 random(8);
  const LeafVoxels leaf = RandomLeaf(&random, 1.0, /*smooth=*/true, /*color=*/false);
  EXPECT_LT(PackLeaf(ViewOf(leaf)).size(), 3 * kLeafVoxels);
}

TEST(UnpackLeaf, RefusesEveryTruncation) {
  std::mt19937 random(9);
  for (const bool smooth : {false, true}) {
    const LeafVoxels leaf = RandomLeaf(&random, 0.6, smooth, smooth);
    const std::string packed = PackLeaf(ViewOf(leaf));
    LeafVoxels unpacked;
    for (std::size_t length = 1; length < packed.size(); ++length) {
      const absl::Status status = UnpackLeaf(packed.substr(0, length), &unpacked);
      ASSERT_EQ(status.code(), absl::StatusCode::kDataLoss) << length;
      ASSERT_EQ(ReasonOf(status), reason::kChecksum);
    }
    EXPECT_FALSE(UnpackLeaf(packed + "x", &unpacked).ok());
  }
}

TEST(UnpackLeaf, SurvivesDamage) {
  std::mt19937 random(10);
  const LeafVoxels leaf = RandomLeaf(&random, 0.6, /*smooth=*/true, /*color=*/true);
  const std::string packed = PackLeaf(ViewOf(leaf));
  for (std::size_t at = 0; at < packed.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = packed;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      LeafVoxels unpacked;
      if (!UnpackLeaf(damaged, &unpacked).ok()) continue;
      // Every leaf that the decoder accepts must be valid input of the encoder.
      for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
        ASSERT_EQ(IsSet(unpacked.observed, offset), unpacked.voxels[offset].weight_units() > 0);
        ASSERT_LE(std::abs(unpacked.voxels[offset].distance_steps()), kMaxDistanceSteps);
      }
    }
  }
}

TEST(UnpackLeaf, RefusesWhatLiesBeyondTheTruncation) {
  const auto unpack = [](std::uint16_t zigzag) {
    std::string packed = "\x02";
    packed += '\x01';
    packed += std::string(63, '\0');
    packed += {static_cast<char>(zigzag & 0xFF), static_cast<char>(zigzag >> 8), '\x02', '\0'};
    LeafVoxels unpacked;
    return UnpackLeaf(packed, &unpacked).code();
  };
  EXPECT_EQ(unpack(2 * kMaxDistanceSteps), absl::StatusCode::kOk);
  EXPECT_EQ(unpack(2 * kMaxDistanceSteps - 1), absl::StatusCode::kOk);
  EXPECT_EQ(unpack(2 * kMaxDistanceSteps + 1), absl::StatusCode::kDataLoss);
  EXPECT_EQ(unpack(2 * kMaxDistanceSteps + 2), absl::StatusCode::kDataLoss);
}

TEST(UnpackLeaf, RefusesABomb) {
  // A zstd frame of 2 KiB that decompresses to 64 MiB of zeros, in place of the leaf body.
  std::string bomb = "\x22";
  bomb += std::string("\x28\xB5\x2F\xFD\xA4\x00\x00\x00\x04", 9);
  for (int block = 0; block < 512; ++block) bomb += std::string("\x02\x00\x10\x00", 4);
  LeafVoxels unpacked;
  EXPECT_EQ(UnpackLeaf(bomb, &unpacked).code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace steadymap
