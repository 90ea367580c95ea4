// Tests clients that lost their server: each attempt must open a new connection. A channel that has
// failed keeps failing for a while without a new attempt, which delays the reconnection.

#include <chrono>
#include <cstdint>

#include <absl/synchronization/notification.h>
#include <absl/time/time.h>
#include <gtest/gtest.h>

#include "client/map/map_mirror.h"
#include "client/transport/channel.h"
#include "client/upload/uploader.h"
#include "tests/support/tcp_proxy.h"

namespace steadymap {
namespace {

using std::chrono::milliseconds;

const MapName kLostMap{"default", "kitchen"};

/// A proxy without a server, which resets all connections.
class LostServer : public ::testing::Test {
 protected:
  LostServer() { proxy_.Refuse(true); }

  /// Twelve attempts of any duration: delays of 10 ms each, 110 ms in all.
  static BackoffOptions TwelveTries() {
    return {.first_delay = milliseconds(10),
            .factor = 1.0,
            .jitter = 0.0,
            .give_up_after = milliseconds(110)};
  }

  TcpProxy proxy_{"127.0.0.1:1"};
  std::uint64_t waits_ = 0;
};

TEST_F(LostServer, IsLookedForByEachTryOfAnUpload) {
  UploaderOptions options;
  options.backoff = TwelveTries();
  options.sleep = [this](milliseconds) { ++waits_; };
  FrameUploader uploader(ChannelsTo(proxy_.address()), kLostMap, options);
  EXPECT_EQ(uploader.Finish().status().code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(waits_, 11U);
  EXPECT_EQ(proxy_.counters().accepted, 12U);
}

TEST_F(LostServer, IsLookedForByEachTryOfAWatch) {
  MirrorOptions options;
  options.backoff = TwelveTries();
  options.sleep = [this](milliseconds) { ++waits_; };
  absl::Notification ended;
  MirrorCallbacks callbacks;
  callbacks.on_state = [&ended](const WatchStateChange& change) {
    if (change.state == WatchState::kEnded) ended.Notify();
  };
  const auto mirror = MapMirror::Start(ChannelsTo(proxy_.address()), kLostMap, options, callbacks);
  ASSERT_TRUE(ended.WaitForNotificationWithTimeout(absl::Seconds(60)));
  EXPECT_EQ(waits_, 11U);
  EXPECT_EQ(proxy_.counters().accepted, 12U);
}

}  // namespace
}  // namespace steadymap
