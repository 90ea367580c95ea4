// Tests the shutdown of a server with clients that could delay it.

#include <array>
#include <chrono>
#include <cstdint>
#include <future>
#include <string>

#include <arpa/inet.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/contract/object_map.h"
#include "tests/contract/test_service.h"
#include "tests/support/descriptor.h"

namespace steadymap {
namespace {

// Much more than a shutdown takes, less than the 20 s that gRPC allows a client for its last ping.
constexpr std::chrono::seconds kLongestStop{15};

constexpr std::chrono::hours kAnyTime{1};

/// Connects like an HTTP/2 client and sends nothing more.
Descriptor ConnectSilently(int port) {
  Descriptor peer(::socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(peer.number(), reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  const std::string greeting("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 24 + 9);
  EXPECT_EQ(::write(peer.number(), greeting.data(), greeting.size()),
            static_cast<ssize_t>(greeting.size()));
  std::array<char, 9> settings{};
  EXPECT_GT(::read(peer.number(), settings.data(), settings.size()), 0);
  return peer;
}

TEST(StoppedServer, IsNotKeptByAConnectionThatAnswersNothing) {
  TestService service(Transport::kLoopback);
  const Descriptor silent = ConnectSilently(service.server().port());
  std::future<void> stopped =
      std::async(std::launch::async, [&] { service.server().Shutdown(kAnyTime); });
  EXPECT_EQ(stopped.wait_for(kLongestStop), std::future_status::ready);
}

TEST(StoppedServer, IsNotKeptByAnExportThatNobodyReads) {
  TestService service(Transport::kLoopback);
  v1::ExportMapRequest request;
  request.set_map(service.CreateMap("hall"));
  request.set_format(v1::EXPORT_FORMAT_PLY);
  StoreObjectMap(&service);
  // More than a connection buffers.
  ASSERT_GT(service.Export(request).value().size(), 200'000U);
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);  // By default it buffers more and more.
  const auto channel =
      grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(service.server().port()),
                                grpc::InsecureChannelCredentials(),
                                arguments);
  const auto queries = v1::QueryService::NewStub(channel);
  grpc::ClientContext context;
  const auto reader = queries->ExportMap(&context, request);
  v1::ExportMapResponse header;
  ASSERT_TRUE(reader->Read(&header));
  std::future<void> stopped =
      std::async(std::launch::async, [&] { service.server().Shutdown(kAnyTime); });
  EXPECT_EQ(stopped.wait_for(kLongestStop), std::future_status::ready);
  context.TryCancel();
}

}  // namespace
}  // namespace steadymap
