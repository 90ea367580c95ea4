#pragma once

#include <string>
#include <vector>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// Parses `arguments` (without the program's name) and runs the command. Returns the exit code: 0
/// only on success, 2 for a command line that makes no sense, 1 for everything else. An error is
/// one line on `context.err`.
int RunCommandLine(const std::vector<std::string>& arguments, CommandContext* context);

}  // namespace steadymap
