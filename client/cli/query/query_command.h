#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// `steadymap query`. Lives as long as the parsed command line.
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
