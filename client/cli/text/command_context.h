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

/// The environment of a command. One process runs one command.
struct CommandContext {
  std::ostream& out;                      ///< Output of results.
  std::ostream& err;                      ///< Output of progress, warnings and the one-line error.
  bool err_is_terminal = false;           ///< True if progress may be redrawn in place.
  std::string server = "localhost:7443";  ///< `HOST:PORT`.

  /// Creates the channel to `server`.
  std::function<std::shared_ptr<grpc::ChannelInterface>(const std::string& server)> open_channel{};

  /// Runs the command. Set by the parsed command.
  std::function<absl::Status()> action{};

  std::shared_ptr<grpc::ChannelInterface> Channel() const { return open_channel(server); }

  /// Returns a function that opens channels, for users that reconnect. The context must outlive it.
  ChannelOpener Channels() const {
    return [this] { return Channel(); };
  }
};

}  // namespace steadymap
