#pragma once

#include <utility>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/config/listen_address.h"

namespace steadymap {

/// A socket, closed when it is destroyed. Movable; one that was moved from holds none.
class Socket {
 public:
  Socket() = default;

  /// Takes the descriptor over; -1 for none.
  explicit Socket(int descriptor) : descriptor_(descriptor) {}

  ~Socket();

  Socket(Socket&& other) noexcept : descriptor_(other.Release()) {}

  Socket& operator=(Socket&& other) noexcept;

  /// -1 if there is none.
  int descriptor() const { return descriptor_; }

  /// Gives the descriptor away: from now on the caller closes it.
  int Release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

/// Sockets that listen, non-blocking: a host name may stand for several addresses.
struct ListeningSockets {
  std::vector<Socket> sockets;  ///< At least one.
  int port = 0;                 ///< The same for all; 0 for a unix socket.
};

/// Listens at an address. `0.0.0.0` takes IPv4 alone, `[::]` both; a unix socket that nobody
/// listens at any more is replaced. Errors: `Unavailable`, with the reason that the system gives,
/// if an address is in use or none of the host's can be listened at.
absl::StatusOr<ListeningSockets> ListenAt(const ListenAddress& address);

}  // namespace steadymap
