#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap evaluate-rooms`. Its lifetime must cover parsing and execution.
class EvaluateRoomsCommand {
 public:
  EvaluateRoomsCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::vector<std::string> changes_;
  std::vector<std::string> variations_;
  std::string policy_ = "pocd";
  std::vector<std::string> parameters_;
  std::string labels_;
  std::size_t cases_ = 4;
  std::uint64_t seed_ = 1;
  bool with_faults_ = false;
};

}  // namespace steadymap
