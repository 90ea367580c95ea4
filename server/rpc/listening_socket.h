#pragma once

#include <utility>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/config/listen_address.h"

namespace steadymap {

/// A socket; the destructor closes it. Movable; a moved-from object contains no socket.
class Socket {
 public:
  Socket() = default;

  /// Takes ownership of the descriptor; -1 means no socket.
  explicit Socket(int descriptor) : descriptor_(descriptor) {}

  ~Socket();

  Socket(Socket&& other) noexcept : descriptor_(other.Release()) {}

  Socket& operator=(Socket&& other) noexcept;

  /// Returns the descriptor; -1 if there is no socket.
  int descriptor() const { return descriptor_; }

  /// Transfers the descriptor to the caller, which must close it.
  int Release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_ = -1;
};

/// Non-blocking listening sockets; a host name can have several addresses.
struct ListeningSockets {
  std::vector<Socket> sockets;  ///< At least one.
  int port = 0;                 ///< Common to all; 0 for a unix socket.
};

/// Listens on an address. `0.0.0.0` accepts IPv4 only, `[::]` accepts both. A unix socket without a
/// listening process is replaced. Errors: `Unavailable`, with the system's reason, if an address is
/// in use or none of the host's addresses can be used.
absl::StatusOr<ListeningSockets> ListenAt(const ListenAddress& address);

}  // namespace steadymap
