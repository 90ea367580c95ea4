#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/cli/text/command_context.h"
#include "client/map/map_client.h"

namespace steadymap {

/// The command `steadymap events`. Its lifetime must cover parsing and execution.
class EventsCommand {
 public:
  EventsCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;
  absl::StatusOr<EventQuery> ReadQuery() const;

  CommandContext* context_;
  std::string map_;
  std::vector<std::string> types_;
  std::vector<std::string> classes_;
  std::vector<std::uint64_t> objects_;
  std::uint64_t changed_since_ = 0;
  std::optional<std::string> since_;  ///< Text for `ParseTime`.
  std::optional<std::string> until_;  ///< Text for `ParseTime`.
  bool as_json_ = false;
};

}  // namespace steadymap
