#include "server/rpc/calls_under_way.h"

#include <optional>
#include <thread>

#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

namespace steadymap {
namespace {

constexpr absl::Duration kPatience = absl::Hours(1);

TEST(CallsUnderWay, NoneIsTheEnd) {
  CallsUnderWay calls;
  EXPECT_TRUE(calls.AwaitEnd(absl::InfiniteFuture(), kPatience));
  { const CallsUnderWay::Call call(&calls); }
  EXPECT_TRUE(calls.AwaitEnd(absl::InfiniteFuture(), kPatience));
}

TEST(CallsUnderWay, AreWaitedForUntilTheyEnd) {
  CallsUnderWay calls;
  absl::Notification ended;
  std::optional<CallsUnderWay::Call> first(&calls);
  CallsUnderWay::Call* second = new CallsUnderWay::Call(&calls);
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

TEST(CallsUnderWay, AreNotWaitedForWhereTheirClientsTakeNothing) {
  CallsUnderWay calls;
  CallsUnderWay::Call first(&calls);
  CallsUnderWay::Call second(&calls);
  first.BeginSending();
  second.BeginSending();
  EXPECT_FALSE(calls.AwaitEnd(absl::InfiniteFuture(), absl::ZeroDuration()));
}

TEST(CallsUnderWay, AreWaitedForWhileTheServerIsAtWorkForOne) {
  CallsUnderWay calls;
  CallsUnderWay::Call stalled(&calls);
  CallsUnderWay::Call at_work(&calls);
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
