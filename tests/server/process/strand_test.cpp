#include "server/process/strand.h"

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

#include "tests/support/eventually.h"

namespace steadymap {
namespace {

using std::chrono::milliseconds;

/// Stops a strand and waits until it has stopped.
void StopAndWait(Strand* strand) {
  absl::Notification stopped;
  strand->Stop([&stopped] { stopped.Notify(); });
  stopped.WaitForNotification();
}

class StrandTest : public ::testing::Test {
 protected:
  WorkerPool pool_{"strand", 4, 16};
};

TEST_F(StrandTest, NeverTwoStepsAtOnceAndNoWakeIsLost) {
  constexpr int kThreads = 8;
  constexpr int kWakes = 2000;
  std::atomic<int> wanted = 0;
  std::atomic<int> seen = 0;
  std::atomic<int> running = 0;
  std::atomic<int> overlaps = 0;
  absl::Notification all_seen;
  const std::shared_ptr<Strand> strand = Strand::Make(&pool_, [&] {
    if (++running != 1) ++overlaps;
    seen = wanted.load();
    const bool is_last = seen == kThreads * kWakes && !all_seen.HasBeenNotified();
    --running;
    if (is_last) all_seen.Notify();
    return Strand::Next::Never();
  });
  std::vector<std::thread> threads;
  threads.reserve(kThreads);
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&] {
      for (int wake = 0; wake < kWakes; ++wake) {
        ++wanted;
        strand->Wake();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  // A step that began after the last wake has observed all values.
  all_seen.WaitForNotification();
  StopAndWait(strand.get());
  EXPECT_EQ(overlaps, 0);
}

TEST_F(StrandTest, WakeDuringAStepRunsAnother) {
  absl::Notification in_first;
  absl::Notification release;
  absl::Notification second_ran;
  int steps = 0;
  const std::shared_ptr<Strand> strand = Strand::Make(&pool_, [&] {
    if (++steps == 1) {
      in_first.Notify();
      release.WaitForNotification();
    } else {
      second_ran.Notify();
    }
    return Strand::Next::Never();
  });
  strand->Wake();
  in_first.WaitForNotification();
  strand->Wake();
  strand->Wake();
  release.Notify();
  second_ran.WaitForNotification();
  StopAndWait(strand.get());
  EXPECT_EQ(steps, 2) << "two wakes during a step are one";
}

TEST_F(StrandTest, NowRunsAgainAndNeverDoesNot) {
  int steps = 0;
  absl::Notification tenth;
  const std::shared_ptr<Strand> strand = Strand::Make(&pool_, [&] {
    if (++steps < 10) return Strand::Next::Now();
    tenth.Notify();
    return Strand::Next::Never();
  });
  strand->Wake();
  tenth.WaitForNotification();
  StopAndWait(strand.get());
  EXPECT_EQ(steps, 10);
}

TEST_F(StrandTest, StopWaitsForTheStepUnderWayAndDropsWhatItHolds) {
  absl::Notification in_step;
  absl::Notification release;
  absl::Notification stopped;
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> watched = held;
  const std::shared_ptr<Strand> strand = Strand::Make(&pool_, [&, held = std::move(held)] {
    in_step.Notify();
    release.WaitForNotification();
    return Strand::Next::Now();
  });
  strand->Wake();
  in_step.WaitForNotification();
  bool was_gone = false;
  strand->Stop([&] {
    was_gone = watched.expired();
    stopped.Notify();
  });
  EXPECT_FALSE(stopped.HasBeenNotified());
  release.Notify();
  stopped.WaitForNotification();
  EXPECT_TRUE(was_gone) << "what the step held goes before anybody hears of the end";
  strand->Wake();
}

TEST_F(StrandTest, StopBeforeAScheduledStepKeepsItFromRunning) {
  WorkerPool pool("one", 1, 16);
  absl::Notification release;
  ASSERT_TRUE(pool.Submit([&] { release.WaitForNotification(); }));
  bool ran = false;
  const std::shared_ptr<Strand> strand = Strand::Make(&pool, [&] {
    ran = true;
    return Strand::Next::Never();
  });
  strand->Wake();
  StopAndWait(strand.get());
  release.Notify();
  pool.Stop();
  EXPECT_FALSE(ran);
}

TEST_F(StrandTest, StepsComeNoEarlierThanTheyWereAskedFor) {
  const Strand::Clock::time_point wanted = Strand::Clock::now() + milliseconds(20);
  absl::Notification second_ran;
  Strand::Clock::time_point ran;
  int steps = 0;
  const std::shared_ptr<Strand> strand = Strand::Make(&pool_, [&] {
    if (++steps == 1) return Strand::Next::At(wanted);
    ran = Strand::Clock::now();
    second_ran.Notify();
    return Strand::Next::Never();
  });
  strand->Wake();
  second_ran.WaitForNotification();
  StopAndWait(strand.get());
  EXPECT_GE(ran, wanted);
}

TEST_F(StrandTest, WakeComesBeforeALaterTimeThatIsDroppedWithTheStrand) {
  absl::Notification first_ran;
  absl::Notification second_ran;
  int steps = 0;
  std::shared_ptr<Strand> strand = Strand::Make(&pool_, [&] {
    (++steps == 1 ? first_ran : second_ran).Notify();
    return Strand::Next::At(Strand::Clock::now() + std::chrono::hours(1));
  });
  strand->Wake();
  first_ran.WaitForNotification();
  strand->Wake();
  second_ran.WaitForNotification();
  StopAndWait(strand.get());
  const std::weak_ptr<Strand> watched = strand;
  strand.reset();
  // The last step may still be finishing.
  EXPECT_TRUE(testing::Eventually([&watched] { return watched.expired(); }))
      << "a time that has not come holds nothing";
}

TEST_F(StrandTest, WakeAndStopAfterThePoolHasStoppedAreHarmless) {
  const std::shared_ptr<Strand> strand = Strand::Make(&pool_, [] { return Strand::Next::Never(); });
  pool_.Stop();
  strand->Wake();
  StopAndWait(strand.get());
}

}  // namespace
}  // namespace steadymap
