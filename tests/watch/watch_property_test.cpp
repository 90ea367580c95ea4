// Tests the promises of watches over random histories: robots that upload, watchers that are
// disconnected, stall, filter and resume, servers that are killed, change lists that are compacted.
//
// STEADYMAP_LAW_SEEDS (default 2) and STEADYMAP_LAW_OPERATIONS (default 250) make the test longer.

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/watch/changing_hall.h"
#include "tests/watch/fleet_mirror.h"
#include "tests/watch/fleet_server.h"
#include "tests/watch/fleet_watcher.h"

namespace steadymap {
namespace {

using ::testing::IsEmpty;

constexpr int kWatchers = 6;
constexpr std::uint32_t kMirrors = 2;
constexpr std::chrono::seconds kCatchUpTime{60};

int NumberFromEnvironment(const char* name, int standard) {
  // This process does not modify its environment.
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return text == nullptr ? standard : std::atoi(text);
}

/// One random history.
class FleetHistory {
 public:
  explicit FleetHistory(std::uint32_t seed) : random_(seed) {
    for (int i = 0; i < kWatchers; ++i) {
      watchers_.push_back(
          std::make_unique<FleetWatcher>(&server_, seed * 100U + static_cast<std::uint32_t>(i)));
    }
    for (std::uint32_t i = 0; i < kMirrors; ++i) {
      mirrors_.push_back(std::make_unique<FleetMirror>(&server_, seed * kMirrors + i));
    }
  }

  void Run(int operations) {
    for (int i = 0; i < operations; ++i) Operate();
    for (const auto& watcher : watchers_) watcher->Resume();
    for (const auto& mirror : mirrors_) mirror->Resume();
    server_.AwaitIntegrated();
  }

  /// Waits until all watchers have the newest revision; returns those that did not in time, with
  /// their revisions.
  std::vector<std::string> AwaitWatchers() {
    const auto deadline = std::chrono::steady_clock::now() + kCatchUpTime;
    const Revision head = server_.history().head();
    std::vector<std::string> behind;
    const auto await = [&](const auto& watchers, const std::string& kind) {
      for (std::size_t i = 0; i < watchers.size(); ++i) {
        while (watchers[i]->revision() < head && std::chrono::steady_clock::now() <= deadline) {
          std::this_thread::yield();
        }
        const Revision revision = watchers[i]->revision();
        if (revision >= head) continue;
        behind.push_back(kind + " " + std::to_string(i) + " at revision " +
                         std::to_string(revision.value()) + " of " + std::to_string(head.value()));
      }
    };
    await(watchers_, "watcher");
    await(mirrors_, "mirror");
    return behind;
  }

  WatchLife Conclude() {
    WatchLife all;
    for (const auto& watcher : watchers_) {
      const WatchLife life = watcher->Stop();
      all.broken.insert(all.broken.end(), life.broken.begin(), life.broken.end());
      all.streams += life.streams;
      all.resumed += life.resumed;
      all.steps += life.steps;
      all.jumps += life.jumps;
      all.patches += life.patches;
      all.continued += life.continued;
      all.events += life.events;
      all.resyncs += life.resyncs;
      all.gaps_told += life.gaps_told;
    }
    return all;
  }

  MirrorLife ConcludeMirrors() {
    MirrorLife all;
    for (const auto& mirror : mirrors_) {
      const MirrorLife life = mirror->Stop();
      all.broken.insert(all.broken.end(), life.broken.begin(), life.broken.end());
      all.steps += life.steps;
      all.snapshots += life.snapshots;
      all.reconnections += life.reconnections;
    }
    return all;
  }

  const MapHistory& history() const { return server_.history(); }

 private:
  void Operate() {
    FleetWatcher& watcher = *watchers_[random_() % watchers_.size()];
    FleetMirror& mirror = *mirrors_[random_() % mirrors_.size()];
    const std::uint64_t draw = random_() % 100;
    if (draw < 50) {
      server_.Upload("robot-" + std::to_string(1 + random_() % 3),
                     hall_.Look(1 + static_cast<int>(random_() % 3)));
    } else if (draw < 58) {
      hall_.Rearrange(&random_);
    } else if (draw < 66) {
      watcher.Cut();
    } else if (draw < 68) {
      mirror.Cut();
    } else if (draw < 76) {
      watcher.Stall();
    } else if (draw < 77) {
      mirror.Stall();
    } else if (draw < 78) {
      mirror.Throttle();
    } else if (draw < 84) {
      watcher.Resume();
    } else if (draw < 86) {
      mirror.Resume();
    } else if (draw < 91) {
      watcher.ChangeMind();
    } else if (draw < 98) {
      server_.Compact();
    } else {
      server_.Kill();
      for (const auto& each : mirrors_) each->FollowServer();
    }
  }

  std::mt19937 random_;
  ChangingHall hall_;
  FleetServer server_;
  std::vector<std::unique_ptr<FleetWatcher>> watchers_;
  std::vector<std::unique_ptr<FleetMirror>> mirrors_;
};

TEST(WatchProperty, HoldsOverRandomHistories) {
  const int seeds = NumberFromEnvironment("STEADYMAP_LAW_SEEDS", 2);
  const int operations = NumberFromEnvironment("STEADYMAP_LAW_OPERATIONS", 250);
  WatchLife all;
  MirrorLife all_mirrored;
  for (int seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    FleetHistory fleet(static_cast<std::uint32_t>(seed));
    fleet.Run(operations);
    ASSERT_THAT(fleet.AwaitWatchers(), IsEmpty());
    const WatchLife life = fleet.Conclude();
    const MirrorLife mirrored = fleet.ConcludeMirrors();
    EXPECT_THAT(life.broken, IsEmpty());
    EXPECT_THAT(mirrored.broken, IsEmpty());
    EXPECT_EQ(fleet.history().gaps(), 0U);
    std::cout << "seed " << seed << ": " << operations << " operations, revision "
              << fleet.history().head().value() << ", " << life.streams << " streams, "
              << life.resumed << " resumed, " << life.steps << " steps, " << life.jumps
              << " over several commits, " << life.patches << " patches, " << life.continued
              << " went on within a step, " << life.events << " events, " << life.resyncs
              << " resyncs, " << life.gaps_told << " gaps told; mirrors: " << mirrored.steps
              << " steps, " << mirrored.reconnections << " reconnections, " << mirrored.snapshots
              << " snapshots\n";
    all_mirrored.steps += mirrored.steps;
    all_mirrored.reconnections += mirrored.reconnections;
    all.steps += life.steps;
    all.jumps += life.jumps;
    all.patches += life.patches;
    all.continued += life.continued;
    all.events += life.events;
    all.resumed += life.resumed;
  }
  // A history without events would prove nothing.
  EXPECT_GT(all.steps, 100U);
  // Watchers fall behind a few times per thousand operations.
  if (seeds * operations >= 4000) {
    EXPECT_GT(all.jumps, 0U);
  }
  EXPECT_GT(all.patches, 0U);
  EXPECT_GT(all.continued, 0U);
  EXPECT_GT(all.events, 0U);
  EXPECT_GT(all.resumed, 0U);
  EXPECT_GT(all_mirrored.steps, 20U);
  EXPECT_GT(all_mirrored.reconnections, 0U);
}

}  // namespace
}  // namespace steadymap
