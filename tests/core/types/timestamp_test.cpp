#include "core/types/timestamp.h"

#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();

Timestamp At(std::int64_t ns) { return Timestamp::FromNanoseconds(ns); }

Duration Of(std::int64_t ns) { return Duration::FromNanoseconds(ns); }

TEST(Timestamp, DifferencesAreExactFarFromTheEpoch) {
  // At this time, seconds stored as `double` have a resolution of about 240 ns.
  const std::int64_t now_ns = 1'800'000'000'000'000'001;
  EXPECT_EQ(At(now_ns) - At(now_ns - 1), Of(1));
  EXPECT_EQ(At(now_ns) + Of(-1), At(now_ns - 1));
  EXPECT_EQ(At(now_ns) - Of(1), At(now_ns - 1));
  EXPECT_EQ((At(3'000'000'000) - At(500'000'000)).seconds(), 2.5);
  EXPECT_EQ(Duration::FromSeconds(-2.5), Of(-2'500'000'000));
}

TEST(Timestamp, DifferencesAndSumsThatOverflowAreTheLargestThereAre) {
  EXPECT_EQ(At(kMost) - At(-1), Of(kMost));
  EXPECT_EQ(At(kLeast) - At(1), Of(kLeast));
  EXPECT_EQ(At(kMost) + Of(1), At(kMost));
  EXPECT_EQ(At(kLeast) + Of(-1), At(kLeast));
  EXPECT_EQ(At(kLeast) - Of(1), At(kLeast));
  EXPECT_EQ(At(kMost) - Of(-1), At(kMost));
}

}  // namespace
}  // namespace steadymap
