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

/// Takes connections for gRPC. Its own listener has no bound, and stops for good when the process
/// runs out of descriptors; here, connections beyond a bound, and those that would take the
/// descriptors kept back for the store and the log, are closed at once. One line a minute says so
/// in the log. Thread-safe.
///
/// The client cannot be told why: before HTTP/2's settings gRPC takes nothing for a reason, and
/// behind them it takes the connection for one that worked, and comes back at once and for ever
/// instead of later and later.
class ConnectionAcceptor {
 public:
  /// Takes over a connection: its descriptor, and that of the socket that it came through.
  using TakeOver = std::function<void(int connection, int listener)>;

  /// Listens, but takes nothing in yet: clients wait. Errors: as `ListenAt`.
  static absl::StatusOr<std::unique_ptr<ConnectionAcceptor>> Listen(const ListenAddress& address,
                                                                    std::size_t max_connections);

  /// Use `Listen`.
  ConnectionAcceptor(ListeningSockets listening, Socket wake, std::size_t max_connections);

  /// Closes the sockets; connections that were taken over are not touched.
  ~ConnectionAcceptor();

  /// The TCP port; 0 for a unix socket.
  int port() const { return listening_.port; }

  /// Starts the thread that accepts; `take_over` is called there. Once.
  void Start(TakeOver take_over);

  /// Ends the thread: nothing is taken over any more.
  void Stop();

  /// The bound for connections from now on.
  void SetMaxConnections(std::size_t max_connections) { max_connections_ = max_connections; }

 private:
  void Run();
  bool AcceptFrom(int listener);
  std::string FindRefusal(int connection);
  void Pause();

  const ListeningSockets listening_;
  const Socket wake_;  ///< An event that says: stop.
  std::atomic<std::size_t> max_connections_;
  std::thread thread_;

  // Of the thread.
  TakeOver take_over_;
  OpenSockets connections_;
  LogLimiter log_limiter_;
  std::size_t refused_ = 0;  ///< Since the last line in the log.
};

}  // namespace steadymap
