#include "server/rpc/stream_limiter.h"

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr LimitedStream::Clock::duration kStallTimeout = std::chrono::seconds(60);

/// Records the calls of the gate.
class NotingStream final : public LimitedStream {
 public:
  void EndIfStalled(Clock::time_point now, Clock::duration timeout) override {
    asked.emplace_back(now, timeout);
  }

  std::vector<std::pair<Clock::time_point, Clock::duration>> asked;
};

class StreamGateTest : public ::testing::Test {
 protected:
  /// Enters a new stream of a peer; null if the gate refuses it.
  std::shared_ptr<NotingStream> Enter(const std::string& peer) {
    auto stream = std::make_shared<NotingStream>();
    const absl::Status status = gate_.Enter(stream, peer);
    if (status.ok()) return stream;
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(ReasonOf(status), "QUEUE_FULL");
    return nullptr;
  }

  StreamLimiter gate_{{.max_streams = 3, .max_per_address = 2, .stall_timeout = kStallTimeout}};
};

TEST_F(StreamGateTest, CountsTheStreamsOfAnAddressWhateverTheirPorts) {
  const auto first = Enter("ipv4:10.0.0.7:50001");
  ASSERT_NE(first, nullptr);
  ASSERT_NE(Enter("ipv4:10.0.0.7:50002"), nullptr);
  EXPECT_EQ(Enter("ipv4:10.0.0.7:50003"), nullptr);
  EXPECT_NE(Enter("ipv4:10.0.0.8:50001"), nullptr);
  EXPECT_EQ(gate_.stream_count(), 3U);
  EXPECT_EQ(Enter("ipv4:10.0.0.9:50001"), nullptr) << "three are all";
  gate_.Leave(first);
  EXPECT_EQ(gate_.stream_count(), 2U);
  EXPECT_NE(Enter("ipv4:10.0.0.7:50004"), nullptr);
}

TEST_F(StreamGateTest, WhatNoLongerCountsIsStillWatched) {
  const auto stalled = Enter("unix:");
  const auto other = Enter("unix:");
  gate_.Discount(stalled);
  gate_.Discount(stalled);
  EXPECT_EQ(gate_.stream_count(), 1U);
  EXPECT_NE(Enter("unix:"), nullptr);
  const auto now = LimitedStream::Clock::now();
  gate_.EndStalled(now);
  EXPECT_THAT(stalled->asked, ::testing::ElementsAre(std::pair(now, kStallTimeout)));
  EXPECT_EQ(other->asked, stalled->asked);
  gate_.Leave(stalled);
  gate_.EndStalled(now);
  EXPECT_EQ(stalled->asked.size(), 1U);
  EXPECT_EQ(gate_.stream_count(), 2U);
}

TEST_F(StreamGateTest, AStreamThatWasNotLetInMayLeave) {
  gate_.Leave(std::make_shared<NotingStream>());
  gate_.Discount(std::make_shared<NotingStream>());
  EXPECT_EQ(gate_.stream_count(), 0U);
}

TEST(AddressOfPeer, LeavesOutThePort) {
  EXPECT_EQ(AddressOfPeer("ipv4:10.0.0.7:51034"), "ipv4:10.0.0.7");
  EXPECT_EQ(AddressOfPeer("ipv6:%5B::1%5D:51034"), "ipv6:%5B::1%5D");
  EXPECT_EQ(AddressOfPeer("unix:/run/a:b"), "unix:/run/a:b");
  EXPECT_EQ(AddressOfPeer(""), "");
}

}  // namespace
}  // namespace steadymap
