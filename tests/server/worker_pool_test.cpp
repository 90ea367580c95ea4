#include "server/worker_pool.h"

#include <string>

#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// A pool of one thread that stands still until it is released, so that tasks pile up.
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
  std::string order_;  ///< Of the tasks, by their letters.
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

}  // namespace
}  // namespace steadymap
