// Tests a watcher that does not read: it receives the reason of the end of its watch when it reads
// again.

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <absl/synchronization/notification.h>
#include <absl/time/time.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "tests/contract/object_map.h"
#include "tests/contract/test_service.h"
#include "tests/contract/watch_client.h"

namespace steadymap {
namespace {

constexpr absl::Duration kLongestWait = absl::Seconds(60);

/// Waits for a text in the log of this process during its lifetime.
class AwaitedLine final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit AwaitedLine(std::string text) : text_(std::move(text)) {}

  bool Await() { return came_.WaitForNotificationWithTimeout(kLongestWait); }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string line(message.payload.data(), message.payload.size());
    if (line.find(text_) != std::string::npos && !came_.HasBeenNotified()) came_.Notify();
  }

  void flush_() override {}

 private:
  const std::string text_;
  absl::Notification came_;
};

TEST(SlowWatcher, LearnsWhyItWasEndedWhenItReadsAgain) {
  const auto ended = std::make_shared<AwaitedLine>("the watcher has read nothing");
  spdlog::default_logger()->sinks().push_back(ended);
  {
    // Every watcher with a message in transit counts as stalled at the check, every second.
    TestService service(Transport::kLoopback,
                        [](ServerConfig* config) { config->watch.stall_timeout = {}; });
    v1::WatchMapRequest request;
    request.set_map(service.CreateMap("hall"));
    request.set_start(v1::WATCH_START_SNAPSHOT_THEN_FOLLOW);
    request.set_max_message_bytes(4 << 20);
    StoreMap(&service, MakeCrowdedMap(100), {});
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    // By default the connection buffers more and more unread data.
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    arguments.SetMaxReceiveMessageSize(-1);
    const auto stub = v1::WatchService::NewStub(
        grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(service.server().port()),
                                  grpc::InsecureChannelCredentials(),
                                  arguments));
    WatchClient watch(stub.get(), request);
    ASSERT_TRUE(watch.Read().has_value());
    ASSERT_TRUE(ended->Await());
    const std::optional<v1::WatchMapResponse> on_its_way = watch.Read();
    ASSERT_TRUE(on_its_way.has_value());
    EXPECT_TRUE(on_its_way->has_snapshot());
    EXPECT_FALSE(watch.Read().has_value());
    EXPECT_THAT(watch.End(), IsError(absl::StatusCode::kAborted, "SLOW_CONSUMER", ""));
  }
  spdlog::default_logger()->sinks().pop_back();
}

}  // namespace
}  // namespace steadymap
