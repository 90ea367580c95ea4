#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/process/log_limiter.h"
#include "server/rpc/listening_socket.h"
#include "server/rpc/open_sockets.h"

namespace steadymap {

/// Accepts connections for gRPC. gRPC's own listener has no limit, and stops permanently when the
/// process runs out of descriptors. This acceptor immediately closes connections beyond a limit and
/// connections that would use the descriptors reserved for the store and the log; it logs one line
/// per minute about them. Thread-safe.
///
/// The reason cannot be sent to the client. Before the HTTP/2 settings exchange, gRPC clients
/// ignore any reason. After it, they count the connection as successful and reconnect immediately
/// and without limit, instead of with exponential backoff.
class ConnectionAcceptor {
 public:
  /// Takes ownership of a connection: its descriptor, and the descriptor of its listening socket.
  using TakeOver = std::function<void(int connection, int listener)>;

  /// Starts to listen but accepts no connection yet: clients wait. Errors: those of `ListenAt`.
  static absl::StatusOr<std::unique_ptr<ConnectionAcceptor>> Listen(const ListenAddress& address,
                                                                    std::size_t max_connections);

  /// Used only by `Listen`.
  ConnectionAcceptor(ListeningSockets listening, Socket wake, std::size_t max_connections);

  /// Closes the listening sockets; does not affect accepted connections.
  ~ConnectionAcceptor();

  /// Returns the TCP port; 0 for a unix socket.
  int port() const { return listening_.port; }

  /// Starts the accepting thread, which calls `take_over` for each connection. Call once.
  void Start(TakeOver take_over);

  /// Ends the thread: no further connection is accepted.
  void Stop();

  /// Sets a new limit on the number of connections.
  void SetMaxConnections(std::size_t max_connections) { max_connections_ = max_connections; }

 private:
  void Run();
  bool AcceptFrom(int listener);
  std::string FindRefusal(int connection);
  void Pause();

  const ListeningSockets listening_;
  const Socket wake_;  ///< Eventfd that ends the thread.
  std::atomic<std::size_t> max_connections_;
  std::thread thread_;

  // Used only by the thread.
  TakeOver take_over_;
  OpenSockets connections_;
  LogLimiter log_limiter_;
  std::size_t refused_ = 0;  ///< Number since the last log line.
};

}  // namespace steadymap
