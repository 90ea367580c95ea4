#pragma once

#include <string>
#include <vector>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// Parses `arguments` (without the program name) and runs the command. Returns the exit code: 0 on
/// success, 2 for an invalid command line, 1 for any other error. An error is written as one line
/// to `context.err`.
int RunCommandLine(const std::vector<std::string>& arguments, CommandContext* context);

}  // namespace steadymap
