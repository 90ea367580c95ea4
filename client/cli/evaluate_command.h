#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/command_context.h"
#include "client/evaluation/evaluation.h"

namespace steadymap {

/// `steadymap evaluate`. Lives as long as the parsed command line.
class EvaluateCommand {
 public:
  EvaluateCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;
  absl::StatusOr<Evaluation> EvaluateNamedRoute(const std::string& name) const;

  CommandContext* context_;
  std::vector<std::string> routes_;
  std::vector<std::string> policies_;
  std::vector<std::uint64_t> seeds_ = {1};
  std::size_t stride_ = 1;
  double voxel_size_m_ = 0.0;  ///< 0: as the route says.
  bool is_ideal_ = false;
  bool with_ground_ = false;
};

}  // namespace steadymap
