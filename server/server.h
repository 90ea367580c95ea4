#pragma once

#include <chrono>
#include <memory>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/channel.h>
#include <grpcpp/support/channel_arguments.h>

#include "server/config/server_config.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The daemon without its `main` function: serves all maps of a store over gRPC. Thread-safe.
class Server {
 public:
  /// Starts to listen, to open the maps and to integrate. Calls for a map wait until the map is
  /// open. `config` must have passed `ValidateServerConfig`.
  /// Errors: `Unavailable` if the server cannot listen on the address; errors of the store.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerConfig& config,
                                                       std::unique_ptr<Store> store);

  /// Shuts down like `Shutdown` with a deadline of 0.
  ~Server();

  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Returns the TCP port; 0 for a unix socket.
  int port() const;

  /// Returns a channel to this server that uses no network. Must not be called after `Shutdown`.
  std::shared_ptr<grpc::Channel> InProcessChannel(const grpc::ChannelArguments& arguments);

  /// Starts to drain: the health service reports NOT_SERVING and new uploads are refused with
  /// `DRAINING`. Open upload streams end with `DRAINING` after all their frames are integrated and
  /// acknowledged. Queries are still served. Returns immediately.
  void Drain();

  /// Shuts the server down in this order: drains unless `Drain` was called before; waits until all
  /// uploads have ended; waits for watches and other calls, but cancels calls of clients that have
  /// stopped reading; closes all connections; at `deadline` ends all remaining calls; commits the
  /// integrated frames; ends all threads. Durable frames that are not integrated by then are
  /// integrated at the next start. Only the first call has an effect.
  void Shutdown(std::chrono::milliseconds deadline);

  /// Returns the oldest time of the last progress of all busy threads. A value several seconds in
  /// the past means that a thread hangs.
  std::chrono::steady_clock::time_point last_progress() const;

  /// Sets new limits, effective immediately. `max_message_bytes` and the queue bytes of existing
  /// maps keep their values. Open streams keep their flow-control window.
  void SetLimits(const LimitOptions& limits);

 private:
  class Parts;
  explicit Server(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace steadymap
