#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap export`. Its lifetime must cover parsing and execution.
class ExportCommand {
 public:
  ExportCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string map_;
  std::string format_;
  std::string output_;
  std::string box_;
  std::vector<std::uint64_t> objects_;
};

}  // namespace steadymap
