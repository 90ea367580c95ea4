#include "client/transport/backoff.h"

#include <algorithm>
#include <cstdint>
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
  EXPECT_EQ(backoff.NextDelay({.asked = milliseconds(1'000)}), milliseconds(1'010));
  EXPECT_EQ(backoff.NextDelay(), milliseconds(20));
  EXPECT_EQ(backoff.NextDelay({.asked = milliseconds(2'000)}), milliseconds(2'040));
  EXPECT_FALSE(backoff.NextDelay()) << "the duration of the attempt counts";
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

TEST(Backoff, TimeThatTriesTakeCountsUntilTheServerIsReached) {
  Backoff backoff({.first_delay = milliseconds(10),
                   .max_delay = milliseconds(1'000),
                   .jitter = 0.0,
                   .give_up_after = milliseconds(1'000)},
                  1);
  EXPECT_EQ(backoff.NextDelay({.took = milliseconds(900)}), milliseconds(10));
  backoff.NoteReached();
  EXPECT_EQ(backoff.NextDelay({.took = milliseconds(900)}), milliseconds(20))
      << "the delays keep growing";
  EXPECT_FALSE(backoff.NextDelay({.took = milliseconds(80)}));
}

TEST(Backoff, DelaysStayShortWhileNobodyAnswers) {
  Backoff backoff({.first_delay = milliseconds(100),
                   .max_delay = milliseconds(3'000),
                   .max_unanswered_delay = milliseconds(500),
                   .jitter = 0.0},
                  1);
  for (const int expected : {100, 200, 400, 500, 500}) {
    EXPECT_EQ(backoff.NextDelay({.was_answered = false}), milliseconds(expected));
  }
  for (const int expected : {500, 1'000, 2'000, 3'000}) {
    EXPECT_EQ(backoff.NextDelay({.was_answered = true}), milliseconds(expected));
  }
  EXPECT_EQ(backoff.NextDelay({.was_answered = false}), milliseconds(500));
}

/// Returns the times at which robots that lost their server at time 0 first retry after its return
/// at `back`.
std::vector<milliseconds> FirstTriesBehind(milliseconds back, std::uint64_t robots) {
  std::vector<milliseconds> tries;
  for (std::uint64_t robot = 1; robot <= robots; ++robot) {
    Backoff backoff({}, robot);
    milliseconds now(0);
    while (now < back) now += backoff.NextDelay({.was_answered = false}).value();
    tries.push_back(now);
  }
  std::sort(tries.begin(), tries.end());
  return tries;
}

TEST(Backoff, AFleetIsBackWithinASecondAndNotAllAtOnce) {
  constexpr std::size_t kRobots = 100;
  constexpr std::size_t kHerd = 25;
  for (const int away_ms : {20, 250, 700, 2'000, 30'000}) {
    const std::vector<milliseconds> tries = FirstTriesBehind(milliseconds(away_ms), kRobots);
    EXPECT_LT(tries.back(), milliseconds(away_ms + 1'000)) << "away for " << away_ms << " ms";
    for (std::size_t i = 0; i + kHerd < tries.size(); ++i) {
      EXPECT_GE(tries[i + kHerd] - tries[i], milliseconds(10))
          << kHerd << " robots at once, away for " << away_ms << " ms";
    }
  }
}

}  // namespace
}  // namespace steadymap
