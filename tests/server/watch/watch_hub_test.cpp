#include "server/watch/watch_hub.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/server/watch/recording_watch.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

constexpr MapKey kHall{1};
constexpr MapKey kYard{2};

class WatchHubTest : public ::testing::Test {
 protected:
  std::shared_ptr<RecordingWatch> Enter(MapKey map) {
    auto watch = std::make_shared<RecordingWatch>();
    EXPECT_TRUE(hub_.Enter(map, watch).ok());
    return watch;
  }

  WatchHub hub_{{.store = nullptr,
                 .max_watches = 3,
                 .stall_timeout = absl::Seconds(60),
                 .stall_grace = absl::Seconds(60)}};
};

TEST_F(WatchHubTest, ACommitWakesTheWatchesOfItsMapAlone) {
  const auto hall = Enter(kHall);
  const auto yard = Enter(kYard);
  hub_.OnCommit(kHall);
  EXPECT_EQ(hall->wakes, 1);
  EXPECT_EQ(yard->wakes, 0);
}

TEST_F(WatchHubTest, EndsWhoTakesAMessageForTooLong) {
  const auto stalled = Enter(kHall);
  const auto slow = Enter(kHall);
  const auto idle = Enter(kYard);
  stalled->since = absl::Now() - absl::Seconds(90);
  slow->since = absl::Now() - absl::Seconds(30);
  hub_.EndStalled();
  EXPECT_EQ(ReasonOf(stalled->ended), reason::kSlowConsumer);
  EXPECT_EQ(stalled->cancels, 0) << "it shall hear why";
  for (const auto& watch : {slow, idle}) {
    EXPECT_TRUE(watch->ended.ok());
    EXPECT_EQ(watch->cancels, 0);
  }
}

TEST_F(WatchHubTest, GivesUpWhoDoesNotComeBackToRead) {
  const auto gone = Enter(kHall);
  gone->since = absl::Now() - absl::Seconds(121);
  hub_.EndStalled();
  EXPECT_EQ(gone->cancels, 1);
}

TEST_F(WatchHubTest, TakesNoMoreThanItsLimit) {
  const auto first = Enter(kHall);
  Enter(kHall);
  Enter(kYard);
  const absl::Status full = hub_.Enter(kYard, std::make_shared<RecordingWatch>());
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(full), reason::kQueueFull);
  hub_.Leave(kHall, first);
  EXPECT_EQ(hub_.watch_count(), 2U);
  EXPECT_TRUE(hub_.Enter(kYard, std::make_shared<RecordingWatch>()).ok());
}

TEST_F(WatchHubTest, KnowsWhoIsFurthestBehind) {
  EXPECT_FALSE(hub_.OldestWatched(kHall).has_value());
  Enter(kHall)->has = Revision(9);
  Enter(kHall)->has = Revision(4);
  Enter(kYard)->has = Revision(1);
  EXPECT_EQ(hub_.OldestWatched(kHall), Revision(4));
}

TEST_F(WatchHubTest, DrainingAsksAllToGoAndLetsNobodyIn) {
  const auto watch = Enter(kHall);
  hub_.Drain();
  EXPECT_EQ(watch->drains, 1);
  EXPECT_EQ(ReasonOf(hub_.Enter(kHall, std::make_shared<RecordingWatch>())), reason::kDraining);
  EXPECT_FALSE(hub_.AwaitEmpty(absl::Now()));
  hub_.Leave(kHall, watch);
  EXPECT_TRUE(hub_.AwaitEmpty(absl::Now()));
}

/// Returns an empty step of a map's watch from a revision to the next.
std::shared_ptr<WatchMessages> MakeStep(MapKey map, std::uint64_t from) {
  StepPlan plan;
  plan.from = Revision(from);
  auto snapshot = std::make_shared<MapSnapshot>(VoxelScale{0.05, 0.15});
  snapshot->revision = Revision(from + 1);
  plan.snapshot = snapshot;
  StepKey key;
  key.scope.map = map;
  key.before.revision = Revision(from);
  key.to = {snapshot->revision};
  key.max_message_bytes = 1 << 16;
  return std::make_shared<WatchMessages>(
      WatchMessages::Source{nullptr, MapFilter(), key, {snapshot->revision, EventNumber()}}, plan);
}

TEST_F(WatchHubTest, HoldsTheLastFewStepsForAMinute) {
  std::vector<std::shared_ptr<WatchMessages>> steps;
  for (std::uint64_t i = 0; i < 40; ++i) {
    steps.push_back(MakeStep(kHall, i));
    hub_.Hold(steps.back());
    // Of another watcher whose stream broke within the step.
    hub_.Hold(MakeStep(kHall, i));
  }
  EXPECT_EQ(hub_.FindHeld(steps.front()->key()), nullptr) << "there are too many";
  const StepKey& last = steps.back()->key();
  EXPECT_NE(hub_.FindHeld(steps[20]->key()), nullptr);
  hub_.DropHeld(absl::Now());
  EXPECT_NE(hub_.FindHeld(last), nullptr);
  StepKey other = last;
  other.takes_patches = true;
  EXPECT_EQ(hub_.FindHeld(other), nullptr);
  hub_.DropHeld(absl::Now() + absl::Minutes(2));
  EXPECT_EQ(hub_.FindHeld(last), nullptr);
}

TEST_F(WatchHubTest, ForgetsTheStepsOfAMapThatEnds) {
  const auto hall = MakeStep(kHall, 1);
  const auto yard = MakeStep(kYard, 1);
  hub_.Hold(hall);
  hub_.Hold(yard);
  hub_.EndMap(kHall, absl::NotFoundError("gone"));
  EXPECT_EQ(hub_.FindHeld(hall->key()), nullptr);
  EXPECT_EQ(hub_.FindHeld(yard->key()), yard);
}

TEST_F(WatchHubTest, TheEndOfAMapEndsItsWatches) {
  const auto hall = Enter(kHall);
  const auto yard = Enter(kYard);
  hub_.EndMap(kHall, absl::NotFoundError("gone"));
  EXPECT_TRUE(absl::IsNotFound(hall->ended));
  EXPECT_TRUE(yard->ended.ok());
}

TEST_F(WatchHubTest, AWatcherThatHasGonePlansNoSnapshotAndSpoilsItForNobody) {
  WatchHub::StepRequest request;
  request.scope.map = kHall;
  request.max_message_bytes = std::size_t{1} << 20;
  request.as_snapshot = true;
  request.to.snapshot = std::make_shared<const MapSnapshot>(testing::BoxOverFloor());
  for (const int wanted_for : {0, 1, 30}) {
    int asked = 0;
    request.cancellation = Cancellation([&asked, wanted_for] { return asked++ >= wanted_for; });
    EXPECT_EQ(hub_.FindStep(request).status().code(), absl::StatusCode::kCancelled);
    EXPECT_LE(asked, wanted_for + 5) << "once more for each pass that ends";
  }
  request.cancellation = {};
  const auto step = hub_.FindStep(request);
  ASSERT_TRUE(step.ok()) << step.status();
  EXPECT_GE((*step)->count(), 2U);
}

}  // namespace
}  // namespace steadymap
