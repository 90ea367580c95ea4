#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap evaluate-composite`. Its lifetime must cover parsing and execution.
class EvaluateCompositeCommand {
 public:
  EvaluateCompositeCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string path_;
  std::string format_;
  std::string T_world_dataset_file_;
  std::string policy_ = "pocd";
  std::vector<std::string> parameters_;
  std::string labels_ = "classes";
  std::size_t cases_ = 3;
  std::size_t stride_ = 1;
  std::uint64_t seed_ = 1;
  double voxel_size_m_ = 0.05;
  double max_depth_m_ = 4.0;
  double session_offset_m_ = 0.0;
  bool with_faults_ = false;
};

}  // namespace steadymap
