#include "tests/support/tcp_proxy.h"

#include <cerrno>
#include <chrono>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>

namespace steadymap {
namespace {

using std::chrono::milliseconds;

// Reached only if the proxy hangs; the socket then fails with EAGAIN.
constexpr timeval kPatience{30, 0};

std::string RandomBytes(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

/// A blocking socket with timeouts: its functions end with `errno` instead of hanging.
class TestSocket {
 public:
  explicit TestSocket(int number) : socket_(number) {
    for (const int option : {SO_RCVTIMEO, SO_SNDTIMEO}) {
      setsockopt(socket_.number(), SOL_SOCKET, option, &kPatience, sizeof(kPatience));
    }
  }

  static TestSocket ConnectedTo(const std::string& address) {
    TestSocket made(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(10))));
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const auto* generic = reinterpret_cast<const sockaddr*>(&where);
    if (connect(made.number(), generic, sizeof(where)) != 0) throw std::runtime_error("connect");
    return made;
  }

  int number() const { return socket_.number(); }

  bool Send(const std::string& bytes) const {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t count = send(number(), bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (count < 0) return false;
      sent += static_cast<std::size_t>(count);
    }
    return true;
  }

  void EndSending() const { shutdown(number(), SHUT_WR); }

  /// Returns up to `count` bytes; fewer at the end of the stream or after an error.
  std::string Receive(std::size_t count) const {
    std::string bytes(count, '\0');
    std::size_t received = 0;
    while (received < count) {
      const ssize_t piece = recv(number(), bytes.data() + received, count - received, 0);
      if (piece <= 0) break;
      received += static_cast<std::size_t>(piece);
    }
    bytes.resize(received);
    return bytes;
  }

  /// Returns the end of the stream: 0 for a regular end, or `errno`. Fails on further bytes.
  int End() const {
    char byte = 0;
    const ssize_t count = recv(number(), &byte, 1, 0);
    EXPECT_LE(count, 0) << "bytes instead of an end";
    return count == 0 ? 0 : errno;
  }

  bool HasNothing() const {
    char byte = 0;
    return recv(number(), &byte, 1, MSG_DONTWAIT | MSG_PEEK) < 0 &&
           (errno == EAGAIN || errno == EWOULDBLOCK);
  }

 private:
  Descriptor socket_;
};

/// Listens on a free port of loopback.
class TestListener {
 public:
  TestListener() : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(where);
    auto* generic = reinterpret_cast<sockaddr*>(&where);
    if (bind(socket_.number(), generic, size) != 0 || listen(socket_.number(), 16) != 0 ||
        getsockname(socket_.number(), generic, &size) != 0) {
      throw std::runtime_error("listen");
    }
    setsockopt(socket_.number(), SOL_SOCKET, SO_RCVTIMEO, &kPatience, sizeof(kPatience));
    address_ = "127.0.0.1:" + std::to_string(ntohs(where.sin_port));
  }

  const std::string& address() const { return address_; }

  TestSocket Accept() const {
    return TestSocket(accept4(socket_.number(), nullptr, nullptr, SOCK_CLOEXEC));
  }

 private:
  Descriptor socket_;
  std::string address_;
};

/// Both ends of a connection through a proxy.
struct Ends {
  Ends(const TcpProxy& proxy, const TestListener& listener)
      : client(TestSocket::ConnectedTo(proxy.address())), server(listener.Accept()) {}

  TestSocket client;
  TestSocket server;
};

/// Sends `bytes` from one socket and returns the bytes received by the other.
std::string Carry(const TestSocket& from, const TestSocket& to, const std::string& bytes) {
  std::thread sender([&] { EXPECT_TRUE(from.Send(bytes)); });
  std::string received = to.Receive(bytes.size());
  sender.join();
  return received;
}

/// Returns an address without a listener.
std::string DeadAddress() { return TestListener().address(); }

TEST(TcpProxy, BytesArriveWholeAndInOrderBothWays) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends first(proxy, listener);
  const Ends second(proxy, listener);
  const std::string up = RandomBytes(5'000'001, 1);
  const std::string down = RandomBytes(3'000'001, 2);
  EXPECT_TRUE(Carry(first.client, first.server, up) == up);
  EXPECT_TRUE(Carry(second.server, second.client, down) == down);
  EXPECT_TRUE(Carry(first.server, first.client, down) == down);
  EXPECT_EQ(proxy.counters().to_target_bytes, up.size());
  EXPECT_EQ(proxy.counters().to_clients_bytes, 2 * down.size());
  EXPECT_EQ(proxy.counters().accepted, 2);
}

TEST(TcpProxy, ThrottledBytesArriveWholeAndInOrder) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  proxy.Throttle(1'000'000);
  const std::string bytes = RandomBytes(200'000, 3);
  EXPECT_TRUE(Carry(ends.client, ends.server, bytes) == bytes);
  proxy.Throttle(0);
  EXPECT_TRUE(Carry(ends.server, ends.client, bytes) == bytes);
}

TEST(ProxyLane, MovesNoMoreThanTimeAllows) {
  int pair[2][2];
  for (auto& ends : pair) {
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends), 0);
  }
  const TestSocket source(pair[0][0]);
  const TestSocket in(pair[0][1]);
  const TestSocket out(pair[1][0]);
  const TestSocket destination(pair[1][1]);
  const std::string bytes = RandomBytes(2'000, 4);
  ASSERT_TRUE(source.Send(bytes));
  ProxyLane lane(in.number(), out.number());
  const auto start = ProxyLane::Clock::time_point() + std::chrono::hours(1);
  lane.Refill(start, 10'000);
  EXPECT_FALSE(lane.wants_source());
  std::string moved;
  int turns = 0;
  for (; turns < 100 && moved.size() < bytes.size(); ++turns) {
    // A fiftieth of a second allows 200 bytes; a long pause accumulates at most two turns.
    const milliseconds passed(20 * turns + (turns > 5 ? 1000 : 0));
    lane.Refill(start + passed, 10'000);
    const std::optional<std::size_t> count = lane.Move();
    ASSERT_TRUE(count);
    EXPECT_LE(*count, turns == 6 ? 400 : 200);
    moved += destination.Receive(*count);
  }
  EXPECT_TRUE(moved == bytes);
  EXPECT_EQ(turns, 10);
}

TEST(TcpProxy, CutResetsBothSides) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  EXPECT_EQ(Carry(ends.client, ends.server, "hello"), "hello");
  EXPECT_EQ(proxy.counters().open, 1);
  proxy.Cut();
  EXPECT_EQ(proxy.counters().open, 0);
  EXPECT_EQ(ends.client.End(), ECONNRESET);
  EXPECT_EQ(ends.server.End(), ECONNRESET);
  const Ends again(proxy, listener);
  EXPECT_EQ(Carry(again.client, again.server, "again"), "again");
}

TEST(TcpProxy, StalledBytesArriveAfterResume) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  EXPECT_EQ(Carry(ends.client, ends.server, "before"), "before");
  const std::uint64_t before = proxy.counters().to_target_bytes;
  proxy.Stall();
  ASSERT_TRUE(ends.client.Send("meanwhile"));
  ASSERT_TRUE(ends.server.Send("likewise"));
  EXPECT_EQ(proxy.counters().to_target_bytes, before);
  EXPECT_TRUE(ends.server.HasNothing());
  EXPECT_TRUE(ends.client.HasNothing());
  proxy.Resume();
  EXPECT_EQ(ends.server.Receive(9), "meanwhile");
  EXPECT_EQ(ends.client.Receive(8), "likewise");
}

TEST(TcpProxy, CutEndsStalledConnections) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  proxy.Stall();
  ASSERT_TRUE(ends.client.Send("lost"));
  proxy.Cut();
  EXPECT_EQ(ends.client.End(), ECONNRESET);
  EXPECT_EQ(ends.server.End(), ECONNRESET);
}

TEST(TcpProxy, NewConnectionsLeadToTheNewTarget) {
  const TestListener old_listener;
  const TestListener new_listener;
  TcpProxy proxy(old_listener.address());
  const Ends old_ends(proxy, old_listener);
  proxy.SetTarget(new_listener.address());
  const Ends new_ends(proxy, new_listener);
  EXPECT_EQ(Carry(new_ends.client, new_ends.server, "new"), "new");
  EXPECT_EQ(Carry(old_ends.client, old_ends.server, "old"), "old");
}

TEST(TcpProxy, RefusedClientsAreResetAndOthersStay) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  proxy.Refuse(true);
  EXPECT_EQ(TestSocket::ConnectedTo(proxy.address()).End(), ECONNRESET);
  EXPECT_EQ(Carry(ends.client, ends.server, "stays"), "stays");
  proxy.Refuse(false);
  const Ends served(proxy, listener);
  EXPECT_EQ(Carry(served.server, served.client, "served"), "served");
}

TEST(TcpProxy, TargetThatIsNotThereResetsItsClient) {
  TcpProxy proxy(DeadAddress());
  EXPECT_EQ(TestSocket::ConnectedTo(proxy.address()).End(), ECONNRESET);
}

TEST(TcpProxy, SideThatEndedCanStillBeAnswered) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  ASSERT_TRUE(ends.client.Send("question"));
  ends.client.EndSending();
  EXPECT_EQ(ends.server.Receive(100), "question");
  ASSERT_TRUE(ends.server.Send("answer"));
  ends.server.EndSending();
  EXPECT_EQ(ends.client.Receive(100), "answer");
  EXPECT_EQ(ends.client.End(), 0);
}

TEST(TcpProxy, TargetThatVanishesIsSeenByItsClient) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const TestSocket client = TestSocket::ConnectedTo(proxy.address());
  {
    const TestSocket server = listener.Accept();
    ASSERT_TRUE(server.Send("last words"));
  }
  EXPECT_EQ(client.Receive(100), "last words");
  EXPECT_EQ(client.End(), 0);
}

TEST(TcpProxy, ClientThatDoesNotReadHoldsItsServerBackAndLosesNothing) {
  const TestListener listener;
  TcpProxy proxy(listener.address());
  const Ends ends(proxy, listener);
  const std::string bytes = RandomBytes(std::size_t{64} << 20, 5);
  std::size_t sent = 0;
  std::thread sender([&] { EXPECT_TRUE(ends.server.Send(bytes)); });
  // The proxy has forwarded as many bytes as the client's socket accepts, and stopped.
  do {
    sent = proxy.counters().to_clients_bytes;
    std::this_thread::yield();
  } while (sent == 0);
  EXPECT_LT(sent, bytes.size());
  EXPECT_TRUE(ends.client.Receive(bytes.size()) == bytes);
  sender.join();
}

TEST(TcpProxy, EndOfTheProxyCutsItsConnections) {
  const TestListener listener;
  auto proxy = std::make_unique<TcpProxy>(listener.address());
  const Ends ends(*proxy, listener);
  proxy->Stall();
  proxy.reset();
  EXPECT_EQ(ends.client.End(), ECONNRESET);
  EXPECT_EQ(ends.server.End(), ECONNRESET);
}

TEST(TcpProxy, AddressThatMakesNoSenseThrows) {
  for (const char* text : {"",
                           "localhost:1",
                           "127.0.0.1",
                           "127.0.0.1:",
                           "127.0.0.1:0",
                           "127.0.0.1:65536",
                           "127.0.0.1:12x",
                           "127.0.0.1:-1"}) {
    EXPECT_THROW(TcpProxy proxy(text), std::invalid_argument) << text;
  }
  TcpProxy proxy(DeadAddress());
  EXPECT_THROW(proxy.SetTarget("nowhere"), std::invalid_argument);
}

}  // namespace
}  // namespace steadymap
