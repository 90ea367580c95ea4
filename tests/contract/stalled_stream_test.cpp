// Tests exports and map sections whose clients do not read. In process: there a message is in
// transit until its client reads it, whereas a connection buffers messages
// (message_stream_test.cpp).

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/contract/object_map.h"
#include "tests/contract/test_service.h"

namespace steadymap {
namespace {

using absl::StatusCode;

constexpr std::size_t kStreamsOfAnAddress = 8;

/// Repeats a call while it is refused for lack of capacity; returns its final status.
template <typename Method>
absl::Status OnceThereIsRoom(const Method& call) {
  absl::Status status = call();
  while (ReasonOf(status) == reason::kQueueFull) status = call();
  return status;
}

class StalledStreamTest : public ::testing::Test {
 protected:
  StalledStreamTest() {
    StoreObjectMap(&service_);
    request_.set_map(map_);
    request_.set_format(v1::EXPORT_FORMAT_VDB);
    for (grpc::ClientContext& context : contexts_) {
      SetDeadline(&context);
      readers_.push_back(service_.queries().ExportMap(&context, request_));
      readers_.back()->WaitForInitialMetadata();
    }
  }

  absl::Status Export() { return service_.Export(request_).status(); }

  absl::Status Section() {
    grpc::ClientContext context;
    SetDeadline(&context);
    v1::GetMapSectionRequest request;
    request.set_map(map_);
    const auto reader = service_.queries().GetMapSection(&context, request);
    for (v1::GetMapSectionResponse message; reader->Read(&message);) continue;
    return FromGrpcStatus(reader->Finish());
  }

  TestService service_{Transport::kInProcess, [](ServerConfig* config) {
                         config->watch.stall_timeout = std::chrono::seconds(1);
                       }};
  const std::string map_ = service_.CreateMap("hall");
  v1::ExportMapRequest request_;
  std::array<grpc::ClientContext, kStreamsOfAnAddress> contexts_;
  std::vector<std::unique_ptr<grpc::ClientReader<v1::ExportMapResponse>>> readers_;
};

TEST_F(StalledStreamTest, MakesRoomForOthersAfterTheStallTimeout) {
  EXPECT_THAT(Export(), IsError(StatusCode::kResourceExhausted, "QUEUE_FULL", ""));
  EXPECT_THAT(Section(), IsError(StatusCode::kResourceExhausted, "QUEUE_FULL", ""));
  const absl::Status exported = OnceThereIsRoom([this] { return Export(); });
  EXPECT_TRUE(exported.ok()) << exported;
  const absl::Status section = OnceThereIsRoom([this] { return Section(); });
  EXPECT_TRUE(section.ok()) << section;
  // Streams before their timeout continue once they are read.
  std::size_t ended = 0;
  for (const auto& reader : readers_) {
    bool is_whole = false;
    for (v1::ExportMapResponse message; reader->Read(&message);) is_whole = message.has_trailer();
    const absl::Status status = FromGrpcStatus(reader->Finish());
    EXPECT_EQ(status.ok(), is_whole);
    if (status.ok()) continue;
    ++ended;
    // The reason, or, if the client did not read for another second, only the cancellation.
    EXPECT_TRUE(status.code() == StatusCode::kCancelled || ReasonOf(status) == "SLOW_CONSUMER")
        << status;
  }
  EXPECT_GE(ended, 1U);
}

TEST_F(StalledStreamTest, MakesRoomForOthersWhenItIsCancelled) {
  contexts_[3].TryCancel();
  EXPECT_EQ(readers_[3]->Finish().error_code(), grpc::StatusCode::CANCELLED);
  const absl::Status exported = OnceThereIsRoom([this] { return Export(); });
  EXPECT_TRUE(exported.ok()) << exported;
  for (std::size_t i = 0; i < contexts_.size(); ++i) {
    contexts_[i].TryCancel();
    if (i != 3) readers_[i]->Finish();
  }
}

}  // namespace
}  // namespace steadymap
