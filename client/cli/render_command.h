#pragma once

#include <string>

#include <absl/status/status.h>

#include "client/birds_eye.h"
#include "client/cli/command_context.h"

namespace steadymap {

/// `steadymap render`. Lives as long as the parsed command line.
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
