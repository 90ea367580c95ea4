#include <string>

#include <grpcpp/impl/codegen/client_unary_call.h>
#include <gtest/gtest.h>

#include "server/store/model/store.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using absl::StatusCode;

// Tests protections of the server outside its own checks, and its interfaces for tools.

/// Calls the health service; its messages have two bytes and need no generated code.
std::string HealthOf(TestService* service, const std::string& name) {
  std::string request;
  if (!name.empty()) request = std::string("\x0a") + static_cast<char>(name.size()) + name;
  const grpc::Slice slice(request);
  const grpc::ByteBuffer request_bytes(&slice, 1);
  grpc::ByteBuffer response_bytes;
  grpc::ClientContext context;
  SetDeadline(&context);
  const grpc::internal::RpcMethod method("/grpc.health.v1.Health/Check",
                                         grpc::internal::RpcMethod::NORMAL_RPC);
  const grpc::Status status = grpc::internal::BlockingUnaryCall<grpc::ByteBuffer, grpc::ByteBuffer>(
      service->channel().get(), method, &context, request_bytes, &response_bytes);
  if (!status.ok()) return status.error_message();
  grpc::Slice response;
  EXPECT_TRUE(response_bytes.TrySingleSlice(&response).ok() || response_bytes.Length() == 0);
  if (response.size() != 2) return "UNKNOWN";
  return response.begin()[1] == 1 ? "SERVING" : "NOT_SERVING";
}

TEST(Health, NamedServicesServeUntilTheDrain) {
  TestService service(Transport::kLoopback);
  for (const char* name :
       {"", "steadymap.v1.IngestService", "steadymap.v1.MapService", "steadymap.v1.QueryService"}) {
    EXPECT_EQ(HealthOf(&service, name), "SERVING") << name;
  }
  service.server().Drain();
  EXPECT_EQ(HealthOf(&service, ""), "NOT_SERVING");
  EXPECT_EQ(HealthOf(&service, "steadymap.v1.IngestService"), "NOT_SERVING");
}

TEST(Health, AMapThatCannotBeWrittenToLeavesTheServiceServing) {
  TestService service(Transport::kLoopback);
  const UploadSession session{service.CreateMap("hall")};
  service.store().FailNextAppend();
  EXPECT_FALSE(UploadAndClose(&service, session, MakeBatch(1, 1)).ok());
  EXPECT_EQ(HealthOf(&service, "steadymap.v1.IngestService"), "SERVING");
  EXPECT_EQ(HealthOf(&service, "steadymap.v1.QueryService"), "SERVING");
}

TEST(Transport, CompressedMessageIsRefusedBeforeItIsInflated) {
  TestService service(Transport::kLoopback);
  v1::UploadFrameBatchRequest request;
  request.set_map(service.CreateMap("hall"));
  request.set_robot("robot");
  request.set_session("session");
  request.mutable_batch()->add_frames()->mutable_depth()->set_data(std::string(200U << 20, '\0'));
  v1::UploadFrameBatchResponse response;
  const absl::Status status = Call([&](auto* context) {
    context->set_compression_algorithm(GRPC_COMPRESS_GZIP);
    return service.ingest().UploadFrameBatch(context, request, &response);
  });
  EXPECT_EQ(status.code(), StatusCode::kUnimplemented) << status;
  EXPECT_TRUE(service.GetMap(request.map()).ok());
}

TEST(Transport, MessageFarBeyondTheLimitIsRefused) {
  TestService service(Transport::kLoopback);
  const UploadSession session{service.CreateMap("hall")};
  v1::FrameBatch batch = MakeBatch(1, 1);
  batch.mutable_frames(0)->mutable_depth()->set_data(std::string(64U << 20, 'x'));
  const absl::Status status = UploadAndClose(&service, session, batch);
  EXPECT_EQ(status.code(), StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(ReasonOf(status), "MESSAGE_TOO_LARGE");
  EXPECT_TRUE(UploadAndClose(&service, session, MakeBatch(1, 1)).ok());
}

TEST(Transport, SecondServerOnThePortIsToldSo) {
  TestService service(Transport::kLoopback);
  ServerConfig config;
  config.listen = "127.0.0.1:" + std::to_string(service.server().port());
  const auto second = Server::Start(config, std::make_unique<MemoryStore>());
  EXPECT_EQ(second.status().code(), StatusCode::kUnavailable);
}

TEST(Disk, MapGoesOnWhereItStoppedBitForBit) {
  std::string undisturbed;
  {
    TestService service(Transport::kLoopback);
    const UploadSession session{service.CreateMap("hall")};
    ASSERT_TRUE(UploadAndClose(&service, session, MakeBatch(1, 12)).ok());
    undisturbed = *service.Export(session.map, v1::EXPORT_FORMAT_VDB);
  }
  const TemporaryFolder folder;
  UploadSession session;
  {
    TestService service(Transport::kLoopback, *Store::Open(folder.path(), StoreOptions()));
    session.map = service.CreateMap("hall");
    ASSERT_TRUE(UploadAndClose(&service, session, MakeBatch(1, 4)).ok());
    UploadClient client(&service);
    ASSERT_TRUE(client.Open(session).ok());
    ASSERT_TRUE(client.Send(MakeBatch(5, 5)));
    ASSERT_TRUE(client.ReadUntil(v1::ACK_LEVEL_DURABLE, 9));
  }
  TestService service(Transport::kLoopback, *Store::Open(folder.path(), StoreOptions()));
  UploadClient client(&service);
  EXPECT_EQ(client.Open(session)->resume_client_seq(), 9U);
  ASSERT_TRUE(client.Send(MakeBatch(7, 6)));
  EXPECT_TRUE(client.Close().ok());
  EXPECT_EQ(service.GetMap(session.map)->state().revision(), 12U);
  EXPECT_EQ(*service.Export(session.map, v1::EXPORT_FORMAT_VDB), undisturbed);
}

// The queue's bytes hold about two of the frames: the others must wait, and no upload may wait
// forever.
TEST(Memory, UploadLargerThanTheBudgetGoesThroughBitByBit) {
  TestService service(Transport::kLoopback, [](ServerConfig* config) {
    config->limits.queue_bytes_per_map = 32'000;
    config->limits.queue_bytes_total = 40'000;
  });
  const std::string map = service.CreateMap("hall");
  UploadClient first(&service);
  UploadClient second(&service);
  ASSERT_TRUE(first.Open({map, "robot-1"}).ok());
  ASSERT_TRUE(second.Open({map, "robot-2"}).ok());
  ASSERT_TRUE(first.Send(MakeBatch(1, 40)));
  ASSERT_TRUE(second.Send(MakeBatch(1, 40)));
  EXPECT_TRUE(second.Close().ok());
  EXPECT_TRUE(first.Close().ok());
  EXPECT_EQ(service.GetMap(map)->state().revision(), 80U);
}

TEST(Memory, FullServerTakesNoMoreButAnswersAndGoesOnByItself) {
  TestService service(Transport::kLoopback);
  const std::string map = service.CreateMap("hall");
  ASSERT_TRUE(UploadAndClose(&service, {map}, MakeBatch(1, 3)).ok());
  LimitOptions limits;
  limits.memory_bytes = 1;
  service.server().SetLimits(limits);
  const auto is_full = IsError(absl::StatusCode::kResourceExhausted, "MEMORY_LOW", "");
  const absl::Status refused = UploadAndClose(&service, {map}, MakeBatch(4, 3));
  EXPECT_THAT(refused, is_full);
  EXPECT_GT(RetryDelayMsOf(refused), 0);
  v1::CreateMapRequest request;
  request.set_parent("tenants/test");
  request.set_map_id("another");
  request.mutable_map()->mutable_config()->set_policy(v1::UPDATE_POLICY_STATIC);
  v1::Map created;
  EXPECT_THAT(
      Call([&](auto* context) { return service.maps().CreateMap(context, request, &created); }),
      is_full);
  EXPECT_EQ(service.GetMap(map)->state().revision(), 3U);
  EXPECT_TRUE(service.Export(map, v1::EXPORT_FORMAT_VDB).ok());
  service.server().SetLimits(LimitOptions());
  EXPECT_TRUE(UploadAndClose(&service, {map}, MakeBatch(4, 3)).ok());
  EXPECT_EQ(service.GetMap(map)->state().revision(), 6U);
}

TEST(Watchdog, ProgressIsRecentWhileTheServerIdles) {
  TestService service(Transport::kInProcess);
  const auto age = std::chrono::steady_clock::now() - service.server().last_progress();
  EXPECT_LT(age, std::chrono::seconds(30));
}

}  // namespace
}  // namespace steadymap
