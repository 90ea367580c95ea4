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

/// `steadymap watch`. Lives as long as the parsed command line.
class WatchCommand {
 public:
  WatchCommand(CLI::App* app, CommandContext* context);

 private:
  absl::Status Run() const;

  /// Where the watch begins, by `--from` and the token file.
  absl::StatusOr<WatchOptions> ReadStart() const;
  absl::StatusOr<MapFilter> ReadFilter(const ClassNames& names) const;

  CommandContext* context_;
  std::string map_;
  WatchFilterOptions filter_;
  std::vector<std::string> kinds_;
  bool archived_ = false;
  std::string from_;
  std::string token_file_;
  std::uint64_t until_revision_ = 0;  ///< 0: none.
  std::uint64_t count_ = 0;           ///< 0: any number.
  double retry_for_s_ = 60.0;
  bool as_json_ = false;
};

}  // namespace steadymap
