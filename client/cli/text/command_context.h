#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>

#include <absl/status/status.h>
#include <grpcpp/channel.h>

#include "client/transport/channel.h"

namespace CLI {
class App;
}

namespace steadymap {

/// What the command line gives every command. One process runs one command.
struct CommandContext {
  std::ostream& out;                      ///< Results.
  std::ostream& err;                      ///< Progress, warnings and the one line of an error.
  bool err_is_terminal = false;           ///< Whether progress may be drawn over itself.
  std::string server = "localhost:7443";  ///< `HOST:PORT`.

  /// Makes the channel to `server`.
  std::function<std::shared_ptr<grpc::ChannelInterface>(const std::string& server)> open_channel{};

  /// Set by the parsed command: what it does.
  std::function<absl::Status()> action{};

  std::shared_ptr<grpc::ChannelInterface> Channel() const { return open_channel(server); }

  /// For what outlives its server; not for longer than the context.
  ChannelOpener Channels() const {
    return [this] { return Channel(); };
  }
};

}  // namespace steadymap
