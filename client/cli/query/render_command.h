#pragma once

#include <string>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"
#include "client/picture/birds_eye.h"

namespace steadymap {

/// The command `steadymap render`. Its lifetime must cover parsing and execution.
class RenderCommand {
 public:
  RenderCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string map_;
  std::string output_;
  BirdsEyeOptions picture_;
  bool by_height_ = false;
};

}  // namespace steadymap
