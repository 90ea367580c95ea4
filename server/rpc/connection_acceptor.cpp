#include "server/rpc/connection_acceptor.h"

#include <cerrno>
#include <chrono>
#include <system_error>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "server/process/descriptors.h"
#include "server/process/worker_pool.h"

namespace steadymap {
namespace {

// Delay before the next attempt when the system has no descriptor or memory for a connection.
constexpr int kPauseMs = 100;

}  // namespace

absl::StatusOr<std::unique_ptr<ConnectionAcceptor>> ConnectionAcceptor::Listen(
    const ListenAddress& address, std::size_t max_connections) {
  absl::StatusOr<ListeningSockets> listening = ListenAt(address);
  if (!listening.ok()) return listening.status();
  Socket wake(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (wake.descriptor() < 0) {
    return absl::UnavailableError(std::generic_category().message(errno));
  }
  return std::make_unique<ConnectionAcceptor>(
      *std::move(listening), std::move(wake), max_connections);
}

ConnectionAcceptor::ConnectionAcceptor(ListeningSockets listening,
                                       Socket wake,
                                       std::size_t max_connections)
    : listening_(std::move(listening)),
      wake_(std::move(wake)),
      max_connections_(max_connections),
      log_limiter_(1, std::chrono::minutes(1)) {}

ConnectionAcceptor::~ConnectionAcceptor() { Stop(); }

void ConnectionAcceptor::Start(TakeOver take_over) {
  take_over_ = std::move(take_over);
  thread_ = std::thread([this] {
    NameThread("accept");
    Run();
  });
}

void ConnectionAcceptor::Stop() {
  if (!thread_.joinable()) return;
  ::eventfd_write(wake_.descriptor(), 1);
  thread_.join();
}

void ConnectionAcceptor::Run() {
  std::vector<pollfd> awaited = {{wake_.descriptor(), POLLIN, 0}};
  for (const Socket& socket : listening_.sockets) {
    awaited.push_back({socket.descriptor(), POLLIN, 0});
  }
  while (true) {
    if (::poll(awaited.data(), awaited.size(), -1) < 0) continue;
    if (awaited.front().revents != 0) return;
    for (const pollfd& listener : awaited) {
      if (listener.revents != 0 && !AcceptFrom(listener.fd)) Pause();
    }
  }
}

/// Accepts one connection. Returns false if the system has no descriptor or memory for it.
bool ConnectionAcceptor::AcceptFrom(int listener) {
  Socket connection(::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (connection.descriptor() < 0) {
    const int error = errno;
    const bool is_full = error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
    // Other errors concern only that connection, for example a client that has disconnected.
    if (is_full && log_limiter_.Allows(LogLimiter::Clock::now())) {
      spdlog::warn("new connections must wait: {}", std::generic_category().message(error));
    }
    return !is_full;
  }
  if (const std::string reason = FindRefusal(connection.descriptor()); !reason.empty()) {
    ++refused_;
    if (log_limiter_.Allows(LogLimiter::Clock::now())) {
      spdlog::warn("connections refused, {} since the last such line: {}",
                   std::exchange(refused_, 0),
                   reason);
    }
    return true;
  }
  connections_.Add(connection.descriptor());
  take_over_(connection.Release(), listener);
  return true;
}

/// Returns the reason for which a connection is refused; empty if it is accepted. The system
/// assigns the lowest free descriptor, so the number of open descriptors is at least `connection`.
std::string ConnectionAcceptor::FindRefusal(int connection) {
  const std::size_t max_connections = max_connections_;
  if (connections_.Count(max_connections) >= max_connections) {
    return absl::StrCat("the server has ", max_connections, " connections, which is the maximum");
  }
  const std::size_t limit = DescriptorLimit();
  if (static_cast<std::size_t>(connection) + ReservedDescriptors(limit) >= limit) {
    return absl::StrCat("the server may have ",
                        limit,
                        " files and connections open, and reserves ",
                        ReservedDescriptors(limit),
                        " of them for its store");
  }
  return {};
}

/// Waits for `kPauseMs` or until `Stop`.
void ConnectionAcceptor::Pause() {
  pollfd wake{wake_.descriptor(), POLLIN, 0};
  ::poll(&wake, 1, kPauseMs);
}

}  // namespace steadymap
