#pragma once

#include <optional>
#include <string>

namespace steadymap {

/// The address on which the server listens: a TCP port of a host, or a unix socket.
struct ListenAddress {
  std::string host;       ///< Name or IP address, without brackets; empty for a unix socket.
  int port = 0;           ///< 0: any free port.
  std::string unix_path;  ///< Empty for TCP.
};

/// Parses `host:port`, `[ipv6]:port` or `unix:path`. Returns none for any other text.
std::optional<ListenAddress> ParseListenAddress(const std::string& listen);

}  // namespace steadymap
