// Tests streams over loopback: read completely, cancelled, and left unread.

#include "server/rpc/message_stream.h"

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <absl/synchronization/notification.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"

#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {
namespace {

using Response = v1::ExportMapResponse;

/// Produces a number of messages of 1 MiB, then the end or an error. If the client does not read,
/// the connection accepts only a few of them.
class LongSource final : public MessageSource<Response> {
 public:
  LongSource(int messages, absl::Status end) : left_(messages), end_(std::move(end)) {}

  absl::StatusOr<bool> Next(Response* message) override {
    if (left_-- > 0) {
      message->set_chunk(std::string(std::size_t{1} << 20, 'x'));
      return true;
    }
    if (!end_.ok()) return end_;
    return false;
  }

 private:
  int left_;
  const absl::Status end_;
};

/// Processes one message until it is cancelled.
class EndlessSource final : public MessageSource<Response> {
 public:
  EndlessSource(Cancellation cancellation, absl::Notification* started)
      : cancellation_(std::move(cancellation)), started_(started) {}

  absl::StatusOr<bool> Next(Response*) override {
    started_->Notify();
    while (!cancellation_.IsCancelled()) std::this_thread::yield();
    return absl::CancelledError("seen");
  }

 private:
  const Cancellation cancellation_;
  absl::Notification* const started_;
};

/// Serves streams from the sources of a test.
class StreamService final
    : public v1::QueryService::WithRawCallbackMethod_ExportMap<v1::QueryService::Service> {
 public:
  using Stream = MessageStream<Response>;

  StreamService(const Stream::Dependencies& dependencies, Stream::Open open)
      : dependencies_(dependencies), open_(std::move(open)) {}

  grpc::ServerWriteReactor<grpc::ByteBuffer>* ExportMap(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer*) override {
    return Stream::Start(
        dependencies_, context, [](const std::function<void()>& go_on) { go_on(); }, open_);
  }

 private:
  const Stream::Dependencies dependencies_;
  const Stream::Open open_;
};

/// A server of such streams, and a client.
class MessageStreamTest : public ::testing::Test {
 protected:
  void Serve(StreamService::Stream::Open open) {
    service_ = std::make_unique<StreamService>(StreamService::Stream::Dependencies{&pool_, &gate_},
                                               std::move(open));
    grpc::ServerBuilder builder;
    int port = 0;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(service_.get());
    server_ = builder.BuildAndStart();
    // The client never accepts more than it requested, whatever else the connection carries.
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    stub_ = v1::QueryService::NewStub(grpc::CreateCustomChannel(
        "127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials(), arguments));
  }

  void ServeLong(int messages, const absl::Status& end) {
    Serve([messages, end](const Cancellation&) -> absl::StatusOr<std::unique_ptr<LongSource>> {
      return std::make_unique<LongSource>(messages, end);
    });
  }

  void TearDown() override {
    if (server_ != nullptr) server_->Shutdown(std::chrono::system_clock::now());
  }

  /// Reads to the end; returns the number of messages and the final status.
  static std::pair<int, absl::Status> ReadAll(grpc::ClientReader<Response>* reader) {
    int messages = 0;
    for (Response message; reader->Read(&message);) ++messages;
    return {messages, FromGrpcStatus(reader->Finish())};
  }

  /// Runs the server's stall check with a clock that advances by one hour per call.
  void LookAnHourLater() {
    now_ += std::chrono::hours(1);
    gate_.EndStalled(now_);
  }

  void EndAllThatStall() {
    while (gate_.stream_count() > 0) LookAnHourLater();
  }

  LimitedStream::Clock::time_point now_ = LimitedStream::Clock::now();
  StreamLimiter gate_{
      {.max_streams = 2, .max_per_address = 2, .stall_timeout = std::chrono::minutes(1)}};
  WorkerPool pool_{"readers", 2, 16};
  std::unique_ptr<StreamService> service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<v1::QueryService::Stub> stub_;
};

TEST_F(MessageStreamTest, BringsAllMessagesAndTheStatusOfTheSource) {
  ServeLong(20, MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, "lost"));
  grpc::ClientContext context;
  const auto [messages, status] = ReadAll(stub_->ExportMap(&context, {}).get());
  EXPECT_EQ(messages, 20);
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(ReasonOf(status), "CHECKSUM");
}

TEST_F(MessageStreamTest, OneThatStallsNoLongerCountsAndTellsWhoReadsAgain) {
  ServeLong(100, absl::OkStatus());
  grpc::ClientContext context;
  const auto reader = stub_->ExportMap(&context, {});
  Response message;
  ASSERT_TRUE(reader->Read(&message));
  EndAllThatStall();
  const auto [messages, status] = ReadAll(reader.get());
  EXPECT_LT(messages, 99);
  EXPECT_EQ(status.code(), absl::StatusCode::kAborted) << status;
  EXPECT_EQ(ReasonOf(status), "SLOW_CONSUMER");
}

TEST_F(MessageStreamTest, OneThatIsNeverReadMakesRoomAndGoes) {
  auto held = std::make_shared<int>();
  const std::weak_ptr<int> of_streams = held;
  Serve(
      [held = std::move(held)](const Cancellation&) -> absl::StatusOr<std::unique_ptr<LongSource>> {
        return std::make_unique<LongSource>(100, absl::OkStatus());
      });
  // The remaining copies of `open` are held by streams and by the service.
  const auto streams_alive = [&of_streams] { return of_streams.use_count() - 1; };
  std::array<grpc::ClientContext, 4> contexts;
  const auto first = stub_->ExportMap(&contexts[0], {});
  const auto second = stub_->ExportMap(&contexts[1], {});
  first->WaitForInitialMetadata();
  second->WaitForInitialMetadata();
  const absl::Status refused = ReadAll(stub_->ExportMap(&contexts[2], {}).get()).second;
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(refused), "QUEUE_FULL");

  EndAllThatStall();
  const auto [messages, status] = ReadAll(stub_->ExportMap(&contexts[3], {}).get());
  EXPECT_EQ(messages, 100);
  EXPECT_TRUE(status.ok()) << status;
  while (streams_alive() > 0) LookAnHourLater();
  EXPECT_EQ(ReadAll(first.get()).second.code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(ReadAll(second.get()).second.code(), absl::StatusCode::kCancelled);
}

TEST_F(MessageStreamTest, OneThatIsReadIsNotTakenForStalled) {
  ServeLong(50, absl::OkStatus());
  grpc::ClientContext context;
  const auto reader = stub_->ExportMap(&context, {});
  int messages = 0;
  for (Response message; reader->Read(&message); ++messages)
    gate_.EndStalled(LimitedStream::Clock::now());
  EXPECT_EQ(messages, 50);
  EXPECT_TRUE(reader->Finish().ok());
}

TEST_F(MessageStreamTest, ASourceAtWorkSeesThatItsClientCancelled) {
  absl::Notification started;
  Serve([&started](Cancellation cancellation) -> absl::StatusOr<std::unique_ptr<EndlessSource>> {
    return std::make_unique<EndlessSource>(std::move(cancellation), &started);
  });
  grpc::ClientContext context;
  const auto reader = stub_->ExportMap(&context, {});
  started.WaitForNotification();
  context.TryCancel();
  EXPECT_EQ(ReadAll(reader.get()).second.code(), absl::StatusCode::kCancelled);
  while (gate_.stream_count() > 0) std::this_thread::yield();
}

TEST_F(MessageStreamTest, ASourceAtWorkSeesThatTheDeadlineHasPassed) {
  absl::Notification started;
  Serve([&started](Cancellation cancellation) -> absl::StatusOr<std::unique_ptr<EndlessSource>> {
    return std::make_unique<EndlessSource>(std::move(cancellation), &started);
  });
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(100));
  const auto reader = stub_->ExportMap(&context, {});
  EXPECT_EQ(ReadAll(reader.get()).second.code(), absl::StatusCode::kDeadlineExceeded);
  while (gate_.stream_count() > 0) std::this_thread::yield();
}

}  // namespace
}  // namespace steadymap
