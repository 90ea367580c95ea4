#pragma once

#include <filesystem>
#include <string>

#include <absl/status/status.h>

#include "client/cli/text/command_context.h"
#include "client/cli/watch/watch_filter_options.h"
#include "client/map/map_mirror.h"
#include "core/map/map_filter.h"
#include "core/types/identifiers.h"

namespace steadymap {

class StopSignal;

/// The command `steadymap mirror`. Its lifetime must cover parsing and execution.
class MirrorCommand {
 public:
  MirrorCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;
  absl::Status Follow(const MapName& name, const MapFilter& filter) const;
  absl::Status WriteFiles(const MapName& name,
                          const MapFilter& filter,
                          const MapSnapshot& map,
                          const std::string& resume_token) const;

  CommandContext* context_;
  std::string map_;
  std::string output_;
  WatchFilterOptions filter_;
  double interval_s_ = 1.0;
  double retry_for_s_ = 60.0;
  bool once_ = false;
};

}  // namespace steadymap
