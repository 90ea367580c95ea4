#pragma once

#include <string>

#include <absl/status/status.h>

#include "client/bench/simulator/simulation.h"
#include "client/cli/text/command_context.h"
#include "client/cli/upload/upload_run.h"

namespace steadymap {

/// The command `steadymap simulate`. Its lifetime must cover parsing and execution.
class SimulateCommand {
 public:
  SimulateCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;
  absl::Status Upload(const SimulationOptions& simulation) const;
  absl::Status Write(const SimulationOptions& simulation) const;

  CommandContext* context_;
  UploadRunOptions options_;
  std::string directory_;
  std::string route_;
  SimulationOptions simulation_;
};

}  // namespace steadymap
