#pragma once

#include "server/command_line.h"
#include "server/config/server_config.h"

namespace steadymap {

/// Runs `steadymapd check` or `steadymapd salvage` over the store of `config`, and prints to stdout
/// what it found or did. Returns the exit code: 0, or 1 if a check has found damage, or 2 if it
/// could not be done, which stderr then explains.
int RunStoreTool(const CommandLine& command_line, const ServerConfig& config);

}  // namespace steadymap
