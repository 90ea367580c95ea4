#include "server/rpc/active_calls.h"

#include <optional>
#include <thread>

#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr absl::Duration kPatience = absl::Hours(1);

TEST(ActiveCalls, NoneIsTheEnd) {
  ActiveCalls calls;
  EXPECT_TRUE(calls.AwaitEnd(absl::InfiniteFuture(), kPatience));
  { const ActiveCalls::Call call(&calls); }
  EXPECT_TRUE(calls.AwaitEnd(absl::InfiniteFuture(), kPatience));
}

TEST(ActiveCalls, AreWaitedForUntilTheyEnd) {
  ActiveCalls calls;
  absl::Notification ended;
  std::optional<ActiveCalls::Call> first(&calls);
  ActiveCalls::Call* second = new ActiveCalls::Call(&calls);
  std::thread waiting([&] {
    EXPECT_TRUE(calls.AwaitEnd(absl::InfiniteFuture(), kPatience));
    EXPECT_TRUE(ended.HasBeenNotified());
  });
  first->BeginSending();
  first.reset();
  second->BeginSending();
  second->EndSending();
  ended.Notify();
  delete second;
  waiting.join();
}

TEST(ActiveCalls, AreNotWaitedForWhereTheirClientsTakeNothing) {
  ActiveCalls calls;
  ActiveCalls::Call first(&calls);
  ActiveCalls::Call second(&calls);
  first.BeginSending();
  second.BeginSending();
  EXPECT_FALSE(calls.AwaitEnd(absl::InfiniteFuture(), absl::ZeroDuration()));
}

TEST(ActiveCalls, AreWaitedForWhileTheServerIsAtWorkForOne) {
  ActiveCalls calls;
  ActiveCalls::Call stalled(&calls);
  ActiveCalls::Call at_work(&calls);
  stalled.BeginSending();
  std::thread waiting(
      [&] { EXPECT_FALSE(calls.AwaitEnd(absl::InfiniteFuture(), absl::ZeroDuration())); });
  at_work.BeginSending();
  waiting.join();
  at_work.EndSending();
  EXPECT_FALSE(calls.AwaitEnd(absl::Now(), kPatience)) << "it ends at the deadline";
}

}  // namespace
}  // namespace steadymap
