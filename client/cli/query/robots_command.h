#pragma once

#include <string>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"
#include "client/cli/text/json_text.h"

#include "steadymap/v1/robot.pb.h"

namespace steadymap {

/// The command `steadymap robots`. Its lifetime must cover parsing and execution.
class RobotsCommand {
 public:
  RobotsCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string map_;
  bool as_json_ = false;
};

/// Returns a robot as one line, without a line feed.
std::string RobotText(const v1::Robot& robot);

/// Returns a robot as JSON: metres in the world frame, radians, seconds since 1970.
Json RobotJson(const v1::Robot& robot);

}  // namespace steadymap
