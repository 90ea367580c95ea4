#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap evaluate-fleet`. Its lifetime must cover parsing and execution.
class EvaluateFleetCommand {
 public:
  EvaluateFleetCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string route_ = "1-5";
  std::vector<std::string> cases_;
  std::string policy_ = "pocd";
  std::vector<std::string> parameters_;
  std::uint64_t seed_ = 1;
};

}  // namespace steadymap
