#pragma once

#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"
#include "client/cli/upload/upload_run.h"
#include "client/dataset/dataset.h"

namespace steadymap {

/// The command `steadymap upload`. Its lifetime must cover parsing and execution.
class UploadCommand {
 public:
  UploadCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  UploadRunOptions options_;
  std::string format_;
  std::vector<std::string> paths_;
  std::string label_map_file_;
  std::string T_world_dataset_file_;
  std::string intrinsics_;    ///< Text of the option.
  std::string depth_sensor_;  ///< A word of `WordsOf(v1::DepthSensor_descriptor())`, or empty.
  DatasetOptions dataset_;
};

}  // namespace steadymap
