#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap query`. Its lifetime must cover parsing and execution.
class QueryCommand {
 public:
  QueryCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string map_;
  std::vector<std::string> points_;
  bool as_json_ = false;
};

}  // namespace steadymap
