#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "client/cli/command_line.h"
#include "client/cli/text/json_text.h"

namespace steadymap {

/// Output and exit code of a command.
struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;

  /// Returns the output parsed as one JSON document.
  Json Document() const { return Json::parse(out); }
};

/// Runs a command of the command line in this process; `open_channel` opens its channels.
template <typename OpenChannel>
Outcome RunCommand(const std::vector<std::string>& arguments, const OpenChannel& open_channel) {
  std::ostringstream out;
  std::ostringstream err;
  CommandContext context{.out = out, .err = err};
  context.open_channel = open_channel;
  const int exit_code = RunCommandLine(arguments, &context);
  return {exit_code, out.str(), err.str()};
}

}  // namespace steadymap
