#include "server/rpc/connection_acceptor.h"

#include <cerrno>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "server/process/descriptors.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using testing::Eventually;
using ::testing::HasSubstr;

/// Holds the connections of an acceptor, like gRPC.
class Owner {
 public:
  explicit Owner(ConnectionAcceptor* acceptor) {
    acceptor->Start([this](int connection, int) {
      const absl::MutexLock lock(&mutex_);
      connections_.emplace_back(connection);
    });
  }

  std::size_t count() const {
    const absl::MutexLock lock(&mutex_);
    return connections_.size();
  }

  void CloseAll() {
    const absl::MutexLock lock(&mutex_);
    connections_.clear();
  }

 private:
  mutable absl::Mutex mutex_;
  std::vector<Socket> connections_ ABSL_GUARDED_BY(mutex_);
};

Socket ConnectTo(int port) {
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(static_cast<std::uint16_t>(port));
  ::inet_pton(AF_INET, "127.0.0.1", &where.sin_addr);
  Socket connection(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(
      ::connect(connection.descriptor(), reinterpret_cast<const sockaddr*>(&where), sizeof(where)),
      0);
  return connection;
}

/// Waits until the peer, which sends no bytes, closes the connection.
bool IsClosed(const Socket& connection) {
  char c = 0;
  return ::recv(connection.descriptor(), &c, 1, 0) == 0;
}

std::unique_ptr<ConnectionAcceptor> ListenAtFreePort(std::size_t max_connections) {
  auto acceptor = ConnectionAcceptor::Listen({"127.0.0.1", 0, {}}, max_connections);
  EXPECT_TRUE(acceptor.ok()) << acceptor.status();
  return *std::move(acceptor);
}

TEST(ConnectionAcceptor, RefusesWhatIsBeyondTheBoundUntilOthersAreClosed) {
  const auto acceptor = ListenAtFreePort(2);
  Owner owner(acceptor.get());
  const Socket first = ConnectTo(acceptor->port());
  const Socket second = ConnectTo(acceptor->port());
  EXPECT_TRUE(Eventually([&] { return owner.count() == 2; }));
  EXPECT_TRUE(IsClosed(ConnectTo(acceptor->port())));
  owner.CloseAll();
  const Socket third = ConnectTo(acceptor->port());
  EXPECT_TRUE(Eventually([&] { return owner.count() == 1; }));
  acceptor->Stop();
}

TEST(ConnectionAcceptor, ABoundThatIsRaisedLetsMoreIn) {
  const auto acceptor = ListenAtFreePort(1);
  Owner owner(acceptor.get());
  const Socket first = ConnectTo(acceptor->port());
  EXPECT_TRUE(IsClosed(ConnectTo(acceptor->port())));
  acceptor->SetMaxConnections(2);
  const Socket second = ConnectTo(acceptor->port());
  EXPECT_TRUE(Eventually([&] { return owner.count() == 2; }));
  acceptor->Stop();
}

TEST(ConnectionAcceptor, AHostIsListenedAtOnAllItsAddressesAtOnePort) {
  auto acceptor = ConnectionAcceptor::Listen({"localhost", 0, {}}, 10);
  ASSERT_TRUE(acceptor.ok()) << acceptor.status();
  Owner owner(acceptor->get());
  EXPECT_GT((*acceptor)->port(), 0);
  const Socket connection = ConnectTo((*acceptor)->port());
  EXPECT_TRUE(Eventually([&] { return owner.count() == 1; }));
  const auto second = ConnectionAcceptor::Listen({"localhost", (*acceptor)->port(), {}}, 10);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("in use"));
  (*acceptor)->Stop();
}

TEST(ConnectionAcceptor, AUnixSocketIsReplacedOnceNobodyListens) {
  const TemporaryFolder folder;
  const std::string path = (folder.path() / "socket").string();
  {
    const auto acceptor = ConnectionAcceptor::Listen({{}, 0, path}, 10);
    ASSERT_TRUE(acceptor.ok()) << acceptor.status();
    EXPECT_EQ((*acceptor)->port(), 0);
    EXPECT_FALSE(ConnectionAcceptor::Listen({{}, 0, path}, 10).ok());
  }
  const auto acceptor = ConnectionAcceptor::Listen({{}, 0, path}, 10);
  ASSERT_TRUE(acceptor.ok()) << acceptor.status();
  Owner owner(acceptor->get());
  sockaddr_un where{};
  where.sun_family = AF_UNIX;
  path.copy(where.sun_path, path.size());
  const Socket connection(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(
      ::connect(connection.descriptor(), reinterpret_cast<const sockaddr*>(&where), sizeof(where)),
      0);
  EXPECT_TRUE(Eventually([&] { return owner.count() == 1; }));
  (*acceptor)->Stop();
}

TEST(ConnectionAcceptor, WhatIsNoHostCannotBeListenedAt) {
  EXPECT_FALSE(ConnectionAcceptor::Listen({"no host", 0, {}}, 10).ok());
  // From the range for documentation: not an address of any machine.
  EXPECT_FALSE(ConnectionAcceptor::Listen({"192.0.2.1", 0, {}}, 10).ok());
  EXPECT_FALSE(ConnectionAcceptor::Listen({{}, 0, "/no/such/folder/socket"}, 10).ok());
}

TEST(OpenSockets, ADescriptorThatIsUsedAgainIsAnother) {
  OpenSockets sockets;
  const int first = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockets.Add(first);
  EXPECT_EQ(sockets.Count(1), 1U);
  ::close(first);
  const Socket second(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(second.descriptor(), first);
  EXPECT_EQ(sockets.Count(1), 0U);
}

TEST(CountFreeDescriptors, CountsWhatIsOpened) {
  const std::size_t before = CountFreeDescriptors();
  EXPECT_LT(before, DescriptorLimit());
  const Socket socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  EXPECT_EQ(CountFreeDescriptors(), before - 1);
}

TEST(ReservedDescriptors, AreAQuarterWithinBounds) {
  EXPECT_EQ(ReservedDescriptors(100), 64U);
  EXPECT_EQ(ReservedDescriptors(512), 128U);
  EXPECT_EQ(ReservedDescriptors(65'536), 4096U);
}

}  // namespace
}  // namespace steadymap
