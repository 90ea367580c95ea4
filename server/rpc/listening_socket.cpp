#include "server/rpc/listening_socket.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <system_error>

#include <absl/strings/str_cat.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

namespace steadymap {
namespace {

constexpr int kBacklog = SOMAXCONN;

// Attempts to find a port that is free on all addresses of the host.
constexpr int kPortTries = 8;

// A connection is closed if the peer acknowledges no data for this long.
constexpr unsigned kUserTimeoutMs = 20'000;

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

absl::Status SocketError(int error) {
  return absl::UnavailableError(std::generic_category().message(error));
}

void SetOption(int descriptor, int level, int option, int value) {
  ::setsockopt(descriptor, level, option, &value, sizeof(value));
}

Socket OpenSocket(int family) {
  return Socket(::socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

int PortOf(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port
                   : reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
}

/// Returns 0, or the errno of the failed call.
int ListenTcp(const addrinfo& where, int port, Socket* socket) {
  *socket = OpenSocket(where.ai_family);
  const int descriptor = socket->descriptor();
  if (descriptor < 0) return errno;
  // Allows a restart while connections of the previous process still exist.
  SetOption(descriptor, SOL_SOCKET, SO_REUSEADDR, 1);
  if (where.ai_family == AF_INET6) SetOption(descriptor, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  // Accepted connections inherit these two options.
  SetOption(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, kUserTimeoutMs);
  sockaddr_storage address{};
  std::memcpy(&address, where.ai_addr, where.ai_addrlen);
  const auto network_port = htons(static_cast<std::uint16_t>(port));
  if (where.ai_family == AF_INET6) {
    reinterpret_cast<sockaddr_in6*>(&address)->sin6_port = network_port;
  } else {
    reinterpret_cast<sockaddr_in*>(&address)->sin_port = network_port;
  }
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), where.ai_addrlen) != 0 ||
      ::listen(descriptor, kBacklog) != 0) {
    return errno;
  }
  return 0;
}

/// Listens on all addresses of a list, on the same port. Addresses that this machine does not have,
/// such as `::1` without IPv6, are skipped.
int ListenAtAll(const addrinfo* list, int port, ListeningSockets* listening) {
  *listening = {.sockets = {}, .port = port};
  int error = EADDRNOTAVAIL;
  for (const addrinfo* where = list; where != nullptr; where = where->ai_next) {
    if (where->ai_family != AF_INET && where->ai_family != AF_INET6) continue;
    Socket socket;
    const int failed = ListenTcp(*where, listening->port, &socket);
    if (failed == EADDRINUSE) return failed;
    if (failed != 0) {
      error = failed;
      continue;
    }
    listening->port = PortOf(socket.descriptor());
    listening->sockets.push_back(std::move(socket));
  }
  return listening->sockets.empty() ? error : 0;
}

absl::StatusOr<ListeningSockets> ListenAtHost(const std::string& host, int port) {
  addrinfo hints{};
  hints.ai_flags = AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found); error != 0) {
    return absl::UnavailableError(::gai_strerror(error));
  }
  const AddressList list(found, &::freeaddrinfo);
  ListeningSockets listening;
  int error = EADDRINUSE;
  const int tries = port == 0 ? kPortTries : 1;
  for (int i = 0; i < tries && error == EADDRINUSE; ++i) {
    error = ListenAtAll(list.get(), port, &listening);
  }
  if (error != 0) return SocketError(error);
  return listening;
}

absl::StatusOr<ListeningSockets> ListenAtPath(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path)) return SocketError(ENAMETOOLONG);
  path.copy(address.sun_path, path.size());
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);

  struct stat file {};

  if (::lstat(path.c_str(), &file) == 0 && S_ISSOCK(file.st_mode)) {
    const Socket probe = OpenSocket(AF_UNIX);
    if (::connect(probe.descriptor(), generic, sizeof(address)) == 0 || errno == EAGAIN) {
      return SocketError(EADDRINUSE);
    }
    ::unlink(path.c_str());
  }
  Socket socket = OpenSocket(AF_UNIX);
  if (socket.descriptor() < 0 || ::bind(socket.descriptor(), generic, sizeof(address)) != 0 ||
      ::listen(socket.descriptor(), kBacklog) != 0) {
    return SocketError(errno);
  }
  ListeningSockets listening;
  listening.sockets.push_back(std::move(socket));
  return listening;
}

}  // namespace

Socket::~Socket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Socket& Socket::operator=(Socket&& other) noexcept {
  if (this == &other) return *this;
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = other.Release();
  return *this;
}

absl::StatusOr<ListeningSockets> ListenAt(const ListenAddress& address) {
  return address.unix_path.empty() ? ListenAtHost(address.host, address.port)
                                   : ListenAtPath(address.unix_path);
}

}  // namespace steadymap
