#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/cli/query/object_text.h"
#include "client/cli/text/command_context.h"
#include "client/cli/watch/watch_filter_options.h"
#include "client/cli/watch/watch_printer.h"
#include "client/watch/map_watch.h"

namespace steadymap {

/// The command `steadymap watch`. Its lifetime must cover parsing and execution.
class WatchCommand {
 public:
  WatchCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  /// Determines the start of the watch from `--from` and the token file.
  absl::StatusOr<WatchOptions> ReadStart() const;
  absl::StatusOr<MapFilter> ReadFilter(const ClassNames& names) const;

  CommandContext* context_;
  std::string map_;
  WatchFilterOptions filter_;
  std::vector<std::string> kinds_;
  bool archived_ = false;
  std::string from_;
  std::string token_file_;
  std::uint64_t until_revision_ = 0;  ///< 0: no end revision.
  std::uint64_t count_ = 0;           ///< 0: no limit.
  double retry_for_s_ = 60.0;
  bool as_json_ = false;
};

}  // namespace steadymap
