#pragma once

#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap map update`. Its lifetime must cover parsing and execution.
class MapUpdateCommand {
 public:
  /// Adds the command to `map`, the parent of all map commands.
  MapUpdateCommand(CLI::App* map, CommandContext* context);

 private:
  absl::Status Run() const;

  CommandContext* context_;
  std::string name_;
  std::vector<std::string> labels_;  ///< `KEY=VALUE` each.
  std::vector<std::string> removed_labels_;
  std::optional<std::string> world_description_;
  std::optional<std::string> classes_file_;
  std::string etag_;
  bool as_json_ = false;
};

}  // namespace steadymap
