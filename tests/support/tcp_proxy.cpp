#include "tests/support/tcp_proxy.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

namespace steadymap {
namespace {

constexpr int kBacklog = 256;

// Small enough that a stall takes effect quickly, large enough for loopback's large segments.
constexpr int kSocketBufferBytes = 256 << 10;

// Entries for poll(2) before those of the connections.
constexpr std::size_t kWakeEntry = 0;
constexpr std::size_t kListenerEntry = 1;
constexpr std::size_t kFirstConnectionEntry = 2;

void Check(int answer, const char* what) {
  if (answer < 0) throw std::system_error(errno, std::generic_category(), what);
}

sockaddr_in ParseAddress(const std::string& text) {
  const std::size_t colon = text.find(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  std::uint16_t port = 0;
  const char* const end = text.data() + text.size();
  if (colon == std::string::npos ||
      inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1 ||
      std::from_chars(text.data() + colon + 1, end, port).ptr != end || port == 0) {
    throw std::invalid_argument("expected HOST:PORT with a numeric IPv4 host, got \"" + text +
                                "\"");
  }
  address.sin_port = htons(port);
  return address;
}

const sockaddr* Generic(const sockaddr_in* address) {
  return reinterpret_cast<const sockaddr*>(address);
}

Descriptor MakeSocket() {
  Descriptor made(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  for (const int option : {SO_RCVBUF, SO_SNDBUF}) {
    Check(setsockopt(made.number(), SOL_SOCKET, option, &kSocketBufferBytes, sizeof(int)),
          "setsockopt");
  }
  return made;
}

void SendAtOnce(const Descriptor& connected) {
  const int on = 1;
  Check(setsockopt(connected.number(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on)), "TCP_NODELAY");
}

/// Returns a listener on a free port of loopback. Accepted sockets inherit its buffer sizes.
Descriptor Listen() {
  Descriptor listener = MakeSocket();
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  Check(bind(listener.number(), Generic(&address), sizeof(address)), "bind");
  Check(listen(listener.number(), kBacklog), "listen");
  return listener;
}

std::string AddressOf(const Descriptor& listener) {
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  Check(getsockname(listener.number(), reinterpret_cast<sockaddr*>(&address), &size),
        "getsockname");
  return "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
}

/// Returns a connecting socket; none if the connection failed at once.
std::optional<Descriptor> Connect(const std::string& target) {
  Descriptor connecting = MakeSocket();
  SendAtOnce(connecting);
  const sockaddr_in address = ParseAddress(target);
  if (connect(connecting.number(), Generic(&address), sizeof(address)) == 0 ||
      errno == EINPROGRESS) {
    return connecting;
  }
  return std::nullopt;
}

}  // namespace

TcpProxy::TcpProxy(const std::string& target)
    : wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      listener_(Listen()),
      address_(AddressOf(listener_)) {
  ParseAddress(target);
  orders_.target = target;
  thread_ = std::thread([this] { Run(); });
}

TcpProxy::~TcpProxy() {
  Order([](Orders* orders) {
    ++orders->cuts;
    orders->stops = true;
  });
  thread_.join();
}

void TcpProxy::SetTarget(const std::string& target) {
  ParseAddress(target);
  Order([&target](Orders* orders) { orders->target = target; });
}

void TcpProxy::Cut() {
  Order([](Orders* orders) { ++orders->cuts; });
}

void TcpProxy::Stall() {
  Order([](Orders* orders) { orders->stalled = true; });
}

void TcpProxy::Resume() {
  Order([](Orders* orders) { orders->stalled = false; });
}

void TcpProxy::Throttle(std::size_t bytes_per_second) {
  Order([bytes_per_second](Orders* orders) { orders->bytes_per_second = bytes_per_second; });
}

void TcpProxy::Refuse(bool refuses) {
  Order([refuses](Orders* orders) { orders->refuses = refuses; });
}

TcpProxy::Counters TcpProxy::counters() {
  return Order([](Orders*) {});
}

/// Gives an order, waits until it is carried out, and returns the counters at that time.
TcpProxy::Counters TcpProxy::Order(const std::function<void(Orders*)>& change) {
  const absl::MutexLock lock(&mutex_);
  change(&orders_);
  const std::uint64_t order = ++ordered_;
  Check(eventfd_write(wake_.number(), 1), "eventfd_write");
  const auto holds = [this, order]()
                         ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return carried_out_ >= order; };
  mutex_.Await(absl::Condition(&holds));
  return published_;
}

// An exception here means a bug in this file or a lack of descriptors; it ends the process with its
// message.
void TcpProxy::Run() {
  while (true) {
    const Orders orders = CarryOutOrders();
    if (orders.stops) return;
    const std::vector<pollfd> polled = Poll(orders);
    if (polled[kWakeEntry].revents != 0) {
      eventfd_t count = 0;
      eventfd_read(wake_.number(), &count);
      continue;
    }
    MoveBytes(polled);
    if (polled[kListenerEntry].revents != 0) AcceptClients(orders);
  }
}

TcpProxy::Orders TcpProxy::CarryOutOrders() {
  const absl::MutexLock lock(&mutex_);
  if (std::exchange(cuts_, orders_.cuts) != orders_.cuts) {
    for (const auto& connection : connections_) connection->Reset();
    connections_.clear();
  }
  counted_.open = connections_.size();
  published_ = counted_;
  carried_out_ = ordered_;
  return orders_;
}

std::vector<pollfd> TcpProxy::Poll(const Orders& orders) {
  std::vector<pollfd> polled{{wake_.number(), POLLIN, 0}, {listener_.number(), POLLIN, 0}};
  std::optional<ProxyConnection::Clock::time_point> due;
  const auto now = ProxyConnection::Clock::now();
  if (!orders.stalled) {
    for (const auto& connection : connections_) {
      connection->Refill(now, orders.bytes_per_second);
      connection->AppendPolled(&polled);
      if (const auto refill = connection->next_refill())
        due = std::min(due.value_or(*refill), *refill);
    }
  }
  int timeout_ms = -1;
  if (due) {
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(*due - now);
    timeout_ms = std::max(1, static_cast<int>(wait.count()));
  }
  if (poll(polled.data(), polled.size(), timeout_ms) < 0 && errno != EINTR) Check(-1, "poll");
  return polled;
}

void TcpProxy::MoveBytes(const std::vector<pollfd>& polled) {
  std::size_t entry = kFirstConnectionEntry;
  for (auto& connection : connections_) {
    if (entry + 1 >= polled.size()) break;
    const ProxyConnection::Turn turn = connection->Move(polled[entry], polled[entry + 1]);
    counted_.to_target_bytes += turn.to_target_bytes;
    counted_.to_clients_bytes += turn.to_client_bytes;
    if (turn.over) connection.reset();
    entry += 2;
  }
  std::erase(connections_, nullptr);
}

void TcpProxy::AcceptClients(const Orders& orders) {
  while (true) {
    const int accepted =
        accept4(listener_.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (accepted < 0) {
      if (errno == EINTR || errno == ECONNABORTED) continue;
      if (errno == EAGAIN || errno == EWOULDBLOCK) return;
    }
    Descriptor client(accepted);
    ++counted_.accepted;
    std::optional<Descriptor> target;
    if (!orders.refuses) target = Connect(orders.target);
    if (!target) {
      ResetSocket(&client);
      continue;
    }
    SendAtOnce(client);
    connections_.push_back(
        std::make_unique<ProxyConnection>(std::move(client), *std::move(target)));
  }
}

}  // namespace steadymap
