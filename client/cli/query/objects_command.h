#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap objects`. Its lifetime must cover parsing and execution.
class ObjectsCommand {
 public:
  ObjectsCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string map_;
  std::vector<std::string> classes_;
  std::string box_;
  double min_stationarity_ = 0.0;
  std::uint64_t changed_since_ = 0;
  bool all_ = false;
  bool as_json_ = false;
};

}  // namespace steadymap
