#pragma once

#include <memory>
#include <string>

#include <grpcpp/channel.h>

namespace steadymap {

/// A plain-text channel to `address` (`HOST:PORT`), with the settings that long uploads need: a
/// keepalive ping every 30 s, reconnection within 2 s once the server is back, no compression by
/// gRPC (the server refuses it), messages as large as the server sends. Connects when first used.
std::shared_ptr<grpc::Channel> OpenChannel(const std::string& address);

}  // namespace steadymap
