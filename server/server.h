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

/// The daemon without its main function: all maps of a store, served over gRPC. Thread-safe.
class Server {
 public:
  /// Starts to listen, to open the maps and to integrate; calls for a map wait until it is open.
  /// `config` must have passed `ValidateServerConfig`.
  /// Errors: `Unavailable` if the address cannot be listened on; what the store answers.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerConfig& config,
                                                       std::unique_ptr<Store> store);

  /// Stops at once, as `Shutdown` with no time left does.
  ~Server();

  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The TCP port; 0 for a unix socket.
  int port() const;

  /// A channel to this server that needs no network. Not after `Shutdown`.
  std::shared_ptr<grpc::Channel> InProcessChannel(const grpc::ChannelArguments& arguments);

  /// Begins to stop: the health service says NOT_SERVING, new uploads are refused with `DRAINING`,
  /// and upload streams end with it when what they sent is integrated and acknowledged. Queries go
  /// on. Returns at once.
  void Drain();

  /// Drains if nobody did, waits until all uploads have ended, lets watches and other calls end but
  /// not those whose clients take nothing, closes all connections, and ends what is left at
  /// `deadline`; then commits what is integrated, and ends all threads. Frames that are durable and
  /// not integrated by then are at the next start. Only the first call does anything.
  void Shutdown(std::chrono::milliseconds deadline);

  /// When every thread that has something to do had last shown that it goes on. Older than some
  /// seconds: something hangs.
  std::chrono::steady_clock::time_point last_progress() const;

  /// Limits that hold from now on; `max_message_bytes` and the queue bytes of maps that are there
  /// already keep their values. Streams under way keep their window.
  void SetLimits(const LimitOptions& limits);

 private:
  class Parts;
  explicit Server(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
};

}  // namespace steadymap
