// Tests more connections than the daemon has file descriptors.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include "tests/support/daemon_process.h"
#include "tests/support/descriptor.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wall_frame.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"
#include "steadymap/v1/map_service.grpc.pb.h"
#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr rlim_t kDescriptors = 512;
constexpr int kConnections = 700;

std::chrono::system_clock::time_point Hang() {
  return std::chrono::system_clock::now() + std::chrono::seconds(60);
}

/// A client with its own connection.
class Client {
 public:
  explicit Client(const std::string& address) {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    channel_ = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  }

  bool Connect() { return channel_->WaitForConnected(Hang()); }

  grpc::Status CreateMap(const std::string& id) {
    v1::CreateMapRequest request;
    request.set_parent("tenants/test");
    request.set_map_id(id);
    v1::Map map;
    grpc::ClientContext context;
    context.set_deadline(Hang());
    return v1::MapService::NewStub(channel_)->CreateMap(&context, request, &map);
  }

  /// Uploads a frame and waits until it is integrated.
  grpc::Status Upload(const std::string& map, std::uint64_t client_seq) {
    v1::UploadFrameBatchRequest request;
    request.set_map("tenants/test/maps/" + map);
    request.set_robot("robot");
    request.set_session("session");
    request.set_wait_for(v1::ACK_LEVEL_INTEGRATED);
    request.mutable_batch()->set_first_client_seq(client_seq);
    *request.mutable_batch()->add_frames() =
        MakeWallFrame({.capture_time_s = 100.0 + static_cast<double>(client_seq)});
    v1::UploadFrameBatchResponse response;
    grpc::ClientContext context;
    context.set_deadline(Hang());
    return v1::IngestService::NewStub(channel_)->UploadFrameBatch(&context, request, &response);
  }

  grpc::Status ListEvents(const std::string& map) {
    v1::ListEventsRequest request;
    request.set_map("tenants/test/maps/" + map);
    v1::ListEventsResponse response;
    grpc::ClientContext context;
    context.set_deadline(Hang());
    return v1::QueryService::NewStub(channel_)->ListEvents(&context, request, &response);
  }

 private:
  std::shared_ptr<grpc::Channel> channel_;
};

/// Opens a TCP connection that sends nothing.
Descriptor ConnectIdly(const std::string& address) {
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port =
      htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  ::inet_pton(AF_INET, "127.0.0.1", &where.sin_addr);
  Descriptor connection(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(
      ::connect(connection.number(), reinterpret_cast<const sockaddr*>(&where), sizeof(where)), 0);
  return connection;
}

/// True if the daemon accepts the connection: it sends bytes then; otherwise it closes.
bool IsTaken(const Descriptor& connection) {
  char c = 0;
  return ::recv(connection.number(), &c, 1, 0) == 1;
}

class ConnectionFlood : public ::testing::Test {
 protected:
  void SetUp() override {
    // This process needs descriptors for its own ends.
    rlimit own{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &own), 0);
    own.rlim_cur = own.rlim_max;
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &own), 0);
    LimitDescriptors(kDescriptors);
  }

  /// Limits the descriptors of the daemon.
  void LimitDescriptors(rlim_t descriptors) {
    const rlimit low{descriptors, descriptors};
    ASSERT_EQ(::prlimit(daemon_.process(), RLIMIT_NOFILE, &low, nullptr), 0);
  }

  TemporaryFolder folder_;
  DaemonProcess daemon_{folder_.path()};
};

TEST_F(ConnectionFlood, StoreAndOpenConnectionsGoOnAndNewOnesAreServedAfterIt) {
  Client early(daemon_.address());
  ASSERT_TRUE(early.CreateMap("hall").ok());
  ASSERT_TRUE(early.Upload("hall", 1).ok());

  std::vector<Descriptor> idle;
  int refused = 0;
  for (int i = 0; i < kConnections; ++i) {
    idle.push_back(ConnectIdly(daemon_.address()));
    if (!IsTaken(idle.back())) ++refused;
  }
  EXPECT_GT(refused, kConnections - static_cast<int>(kDescriptors));
  EXPECT_LT(refused, kConnections - static_cast<int>(kDescriptors) / 2)
      << "half of them can be used";

  EXPECT_TRUE(early.Upload("hall", 2).ok());
  EXPECT_TRUE(early.ListEvents("hall").ok());
  const grpc::Status created = early.CreateMap("yard");
  EXPECT_TRUE(created.ok()) << created.error_message();
  EXPECT_TRUE(early.Upload("yard", 1).ok());
  const grpc::Status late = Client(daemon_.address()).ListEvents("hall");
  EXPECT_EQ(late.error_code(), grpc::StatusCode::UNAVAILABLE);

  idle.clear();
  Client after(daemon_.address());
  ASSERT_TRUE(after.Connect());
  EXPECT_TRUE(after.Upload("hall", 3).ok());
  const ProcessEnd end = daemon_.Terminate();
  EXPECT_EQ(end.exit_code, 0) << end.errors;
  EXPECT_THAT(end.errors, Not(HasSubstr("Too many open files")));
  EXPECT_THAT(
      end.errors,
      HasSubstr(
          "connections refused, 1 since the last such line: the server may have 512 files and "
          "connections open"));
}

TEST_F(ConnectionFlood, MapsAreRefusedBeforeTheirFilesFindNoDescriptor) {
  LimitDescriptors(150);
  Client client(daemon_.address());
  grpc::Status created;
  int maps = 0;
  for (; maps < 100; ++maps) {
    created = client.CreateMap("map-" + std::to_string(maps));
    if (!created.ok()) break;
    EXPECT_TRUE(client.Upload("map-" + std::to_string(maps), 1).ok());
  }
  EXPECT_EQ(created.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(created.error_message(), HasSubstr("ulimit -n"));
  EXPECT_GT(maps, 1);
  for (int map = 0; map < maps; ++map) {
    EXPECT_TRUE(client.Upload("map-" + std::to_string(map), 2).ok()) << map;
  }
  const ProcessEnd end = daemon_.Terminate();
  EXPECT_EQ(end.exit_code, 0) << end.errors;
  EXPECT_THAT(end.errors, Not(HasSubstr("Too many open files")));
}

}  // namespace
}  // namespace steadymap
