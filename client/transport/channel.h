#pragma once

#include <functional>
#include <memory>
#include <string>

#include <grpcpp/channel.h>

namespace steadymap {

/// A plain-text channel to `address` (`HOST:PORT`), with the settings that long uploads need: a
/// keepalive ping every 30 s, no compression by gRPC (the server refuses it), messages as large as
/// the server sends. Connects when first used, over a connection that no other channel shares, and
/// gives up a connection that is not there after 2 s. For calls that are made once: after a lost
/// connection, gRPC does not look for the server again for seconds.
std::shared_ptr<grpc::Channel> OpenChannel(const std::string& address);

/// Opens a channel for each try to reach a server. A new channel knows nothing of failures before
/// it, so the one who tries decides alone when to try again. Called from the threads of those who
/// have it, possibly from several at once.
using ChannelOpener = std::function<std::shared_ptr<grpc::ChannelInterface>()>;

/// Opens channels to `address` by `OpenChannel`.
ChannelOpener ChannelsTo(const std::string& address);

}  // namespace steadymap
