#include "client/backoff.h"

#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

using std::chrono::milliseconds;

TEST(Backoff, DelaysDoubleUpToTheLargest) {
  Backoff backoff({.first_delay = milliseconds(10), .max_delay = milliseconds(50), .jitter = 0.0},
                  1);
  std::vector<milliseconds> delays(5);
  for (milliseconds& delay : delays) delay = backoff.NextDelay().value();
  EXPECT_EQ(delays,
            (std::vector<milliseconds>{milliseconds(10),
                                       milliseconds(20),
                                       milliseconds(40),
                                       milliseconds(50),
                                       milliseconds(50)}));
}

TEST(Backoff, WhatAServerAsksForComesOnTop) {
  Backoff backoff({.first_delay = milliseconds(10),
                   .max_delay = milliseconds(50),
                   .jitter = 0.0,
                   .give_up_after = milliseconds(3'000)},
                  1);
  EXPECT_EQ(backoff.NextDelay(milliseconds(1'000)), milliseconds(1'010));
  EXPECT_EQ(backoff.NextDelay(), milliseconds(20));
  EXPECT_EQ(backoff.NextDelay(milliseconds(2'000)), milliseconds(2'040));
  EXPECT_FALSE(backoff.NextDelay()) << "it counts";
}

TEST(Backoff, JitterStaysWithinItsShareAndVaries) {
  const BackoffOptions options{.first_delay = milliseconds(1'000),
                               .max_delay = milliseconds(1'000),
                               .jitter = 0.2,
                               .give_up_after = milliseconds(1'000'000)};
  Backoff backoff(options, 3);
  milliseconds least(10'000);
  milliseconds most(0);
  for (int i = 0; i < 200; ++i) {
    const milliseconds delay = backoff.NextDelay().value();
    least = std::min(least, delay);
    most = std::max(most, delay);
  }
  EXPECT_GE(least, milliseconds(800));
  EXPECT_LT(least, milliseconds(850));
  EXPECT_GT(most, milliseconds(1'150));
  EXPECT_LE(most, milliseconds(1'200));
}

TEST(Backoff, EqualSeedsGiveEqualDelays) {
  Backoff first({}, 7);
  Backoff second({}, 7);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(first.NextDelay(), second.NextDelay());
}

TEST(Backoff, EndsOnceTheDelaysAddUpAndStartsAnewAfterASuccess) {
  Backoff backoff({.first_delay = milliseconds(10),
                   .max_delay = milliseconds(1'000),
                   .jitter = 0.0,
                   .give_up_after = milliseconds(70)},
                  1);
  EXPECT_TRUE(backoff.NextDelay());  // 10
  EXPECT_TRUE(backoff.NextDelay());  // 30
  EXPECT_TRUE(backoff.NextDelay());  // 70
  EXPECT_FALSE(backoff.NextDelay());
  backoff.Reset();
  EXPECT_EQ(backoff.NextDelay(), milliseconds(10));
}

}  // namespace
}  // namespace steadymap
