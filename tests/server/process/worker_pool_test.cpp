#include "server/process/worker_pool.h"

#include <chrono>
#include <memory>
#include <string>

#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// A pool of one thread, blocked until it is released, so that tasks accumulate.
class WorkerPoolTest : public ::testing::Test {
 protected:
  WorkerPoolTest() {
    EXPECT_TRUE(pool_.TrySubmit([this] {
      standing_.Notify();
      release_.WaitForNotification();
    }));
    standing_.WaitForNotification();
  }

  absl::Notification standing_;
  absl::Notification release_;
  std::string order_;  ///< Letters of the executed tasks, in order.
  WorkerPool pool_{"test", 1, 2};
};

TEST_F(WorkerPoolTest, WorkInStepsTakesTurnsWithTheOthers) {
  EXPECT_TRUE(pool_.TrySubmit([this] { order_ += 'a'; }));
  EXPECT_TRUE(pool_.Submit([this] { order_ += 'b'; }));
  EXPECT_FALSE(pool_.TrySubmit([this] { order_ += 'c'; })) << "two wait already";
  EXPECT_TRUE(pool_.Submit([this] { order_ += 'd'; })) << "whatever their number";
  release_.Notify();
  pool_.Stop();
  EXPECT_EQ(order_, "abd");
  EXPECT_FALSE(pool_.Submit([this] { order_ += 'e'; }));
}

using Clock = WorkerPool::Clock;

TEST_F(WorkerPoolTest, TimedTasksRunInTheOrderOfTheirTimesAndNotBefore) {
  const Clock::time_point now = Clock::now();
  const Clock::time_point late = now + std::chrono::milliseconds(30);
  absl::Notification last_ran;
  Clock::time_point ran;
  pool_.SubmitAt(late, [&] {
    order_ += 'c';
    ran = Clock::now();
    last_ran.Notify();
  });
  pool_.SubmitAt(now + std::chrono::milliseconds(20), [this] { order_ += 'b'; });
  pool_.SubmitAt(now - std::chrono::milliseconds(1), [this] { order_ += 'a'; });
  release_.Notify();
  last_ran.WaitForNotification();
  pool_.Stop();
  EXPECT_EQ(order_, "abc");
  EXPECT_GE(ran, late);
}

TEST_F(WorkerPoolTest, TimedTasksThatHaveNotRunAreDroppedWhenThePoolStops) {
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> watched = held;
  pool_.SubmitAt(Clock::now() + std::chrono::hours(1), [held = std::move(held)] { ++*held; });
  EXPECT_FALSE(watched.expired());
  release_.Notify();
  pool_.Stop();
  EXPECT_TRUE(watched.expired());
  pool_.SubmitAt(Clock::now(), [this] { order_ += 'x'; });
  EXPECT_EQ(order_, "");
}

TEST(WorkerPool, AnIdleThreadTakesOverTheTimesOfOneThatGetsALongTask) {
  for (int round = 0; round < 100; ++round) {
    absl::Notification both_idle;
    absl::Notification timer_ran;
    absl::Notification release;
    WorkerPool pool("pair", 2, 4);
    ASSERT_TRUE(pool.Submit([] {}));
    ASSERT_TRUE(pool.Submit([&] { both_idle.Notify(); }));
    both_idle.WaitForNotification();
    pool.SubmitAt(Clock::now() + std::chrono::milliseconds(5), [&] { timer_ran.Notify(); });
    // Another thread may take this task instead of the one that waits for the timer.
    ASSERT_TRUE(pool.Submit([&] { release.WaitForNotification(); }));
    const bool ran = timer_ran.WaitForNotificationWithTimeout(absl::Seconds(20));
    release.Notify();
    ASSERT_TRUE(ran) << "round " << round;
  }
}

}  // namespace
}  // namespace steadymap
