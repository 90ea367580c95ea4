#include "server/watch_hub.h"

#include <cstddef>
#include <memory>

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/server/noting_watch.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

constexpr MapKey kHall{1};
constexpr MapKey kYard{2};

class WatchHubTest : public ::testing::Test {
 protected:
  std::shared_ptr<NotingWatch> Enter(MapKey map) {
    auto watch = std::make_shared<NotingWatch>();
    EXPECT_TRUE(hub_.Enter(map, watch).ok());
    return watch;
  }

  WatchHub hub_{{.store = nullptr, .max_watches = 3, .stall_timeout = absl::Seconds(60)}};
};

TEST_F(WatchHubTest, ACommitWakesTheWatchesOfItsMapAlone) {
  const auto hall = Enter(kHall);
  const auto yard = Enter(kYard);
  hub_.OnCommit(kHall);
  EXPECT_EQ(hall->wakes, 1);
  EXPECT_EQ(yard->wakes, 0);
}

TEST_F(WatchHubTest, CancelsWhoTakesAMessageForTooLong) {
  const auto stalled = Enter(kHall);
  const auto slow = Enter(kHall);
  const auto idle = Enter(kYard);
  stalled->since = absl::Now() - absl::Seconds(61);
  slow->since = absl::Now() - absl::Seconds(30);
  hub_.CancelStalled();
  EXPECT_EQ(stalled->cancels, 1);
  EXPECT_EQ(slow->cancels, 0);
  EXPECT_EQ(idle->cancels, 0);
}

TEST_F(WatchHubTest, TakesNoMoreThanItsLimit) {
  const auto first = Enter(kHall);
  Enter(kHall);
  Enter(kYard);
  const absl::Status full = hub_.Enter(kYard, std::make_shared<NotingWatch>());
  EXPECT_EQ(full.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(full), reason::kQueueFull);
  hub_.Leave(kHall, first);
  EXPECT_EQ(hub_.watch_count(), 2U);
  EXPECT_TRUE(hub_.Enter(kYard, std::make_shared<NotingWatch>()).ok());
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
  EXPECT_EQ(ReasonOf(hub_.Enter(kHall, std::make_shared<NotingWatch>())), reason::kDraining);
  EXPECT_FALSE(hub_.AwaitEmpty(absl::Now()));
  hub_.Leave(kHall, watch);
  EXPECT_TRUE(hub_.AwaitEmpty(absl::Now()));
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
  request.snapshot = std::make_shared<const MapSnapshot>(testing::BoxOverFloor());
  for (const int wanted_for : {0, 1, 30}) {
    int asked = 0;
    request.check = [&asked, wanted_for] { return asked++ >= wanted_for; };
    EXPECT_EQ(hub_.FindStep(request).status().code(), absl::StatusCode::kCancelled);
    EXPECT_LE(asked, wanted_for + 5) << "once more for each pass that ends";
  }
  request.check = {};
  const auto step = hub_.FindStep(request);
  ASSERT_TRUE(step.ok()) << step.status();
  EXPECT_GE((*step)->count(), 2U);
}

}  // namespace
}  // namespace steadymap
