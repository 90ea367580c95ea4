#pragma once

#include "server/command_line.h"
#include "server/config/server_config.h"

namespace steadymap {

/// Runs `steadymapd check` or `steadymapd salvage` on the store of `config` and prints the findings
/// or the actions to stdout. Returns the exit code: 0; 1 if a check found damage; 2 if the tool
/// could not run, with the reason on stderr.
int RunStoreTool(const CommandLine& command_line, const ServerConfig& config);

}  // namespace steadymap
