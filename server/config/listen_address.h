#pragma once

#include <optional>
#include <string>

namespace steadymap {

/// Where a server listens: a TCP port of a host, or a unix socket.
struct ListenAddress {
  std::string host;       ///< Name or number, without brackets; empty for a unix socket.
  int port = 0;           ///< 0: a free one.
  std::string unix_path;  ///< Empty for TCP.
};

/// Reads `host:port`, `[ipv6]:port` or `unix:path`; none for anything else.
std::optional<ListenAddress> ParseListenAddress(const std::string& listen);

}  // namespace steadymap
