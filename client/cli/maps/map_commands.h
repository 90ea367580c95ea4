#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "client/cli/maps/map_options.h"
#include "client/cli/maps/map_update_command.h"
#include "client/cli/text/command_context.h"

namespace steadymap {

/// The command `steadymap map create|get|list|update|delete`. Its lifetime must cover parsing and
/// execution.
class MapCommands {
 public:
  MapCommands(CLI::App* app, CommandContext* context);

 private:
  void AddCreate(CLI::App* map);
  void AddGet(CLI::App* map);
  void AddList(CLI::App* map);
  void AddDelete(CLI::App* map);

  absl::Status Create() const;
  absl::Status Get() const;
  absl::Status List() const;
  absl::Status Delete() const;

  CommandContext* context_;
  std::string name_;
  std::string tenant_ = "default";
  bool as_json_ = false;
  MapOptions map_options_;
  std::int64_t max_commit_delay_ms_ = 0;  ///< 0: the server's setting.
  std::vector<std::string> labels_;       ///< `KEY=VALUE` each.
  std::optional<std::string> world_description_;
  std::optional<MapUpdateCommand> update_;
};

}  // namespace steadymap
