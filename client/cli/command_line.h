#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/command_context.h"

namespace steadymap {

/// Parses `arguments` (without the program's name) and runs the command. Returns the exit code: 0
/// only on success, 2 for a command line that makes no sense, 1 for everything else. An error is
/// one line on `context.err`.
int RunCommandLine(const std::vector<std::string>& arguments, CommandContext* context);

/// An error as one line without its line feed: what happened, and where the service named them the
/// reason and the field.
std::string ErrorLine(const absl::Status& status, const std::string& server);

}  // namespace steadymap
