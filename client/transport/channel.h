#pragma once

#include <functional>
#include <memory>
#include <string>

#include <grpcpp/channel.h>

namespace steadymap {

/// Returns a plain-text channel to `address` (`HOST:PORT`) with the settings for long uploads: a
/// keepalive ping every 30 s, no gRPC compression (the server rejects it), no limit on received
/// messages. The channel connects on first use, shares its connection with no other channel, and
/// ends an attempt to connect after 2 s. For single calls: after a lost connection, gRPC reconnects
/// only after seconds.
std::shared_ptr<grpc::Channel> OpenChannel(const std::string& address);

/// Opens a channel for each attempt to reach a server. A new channel has no backoff from earlier
/// failures, so the caller alone decides the time of the next attempt. Called from the caller's
/// threads, possibly concurrently.
using ChannelOpener = std::function<std::shared_ptr<grpc::ChannelInterface>()>;

/// Returns an opener that calls `OpenChannel(address)`.
ChannelOpener ChannelsTo(const std::string& address);

}  // namespace steadymap
