#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/cli/query/object_text.h"
#include "core/map/map_filter.h"

namespace CLI {
class App;
}

namespace steadymap {

/// What of a map is watched, as on the command line.
struct WatchFilterOptions {
  std::vector<std::string> boxes;
  std::vector<std::string> classes;    ///< Ids or names.
  std::vector<std::uint64_t> objects;  ///< 0 is the background.
};

/// Adds the options that change a WatchFilterOptions.
void AddWatchFilterOptions(CLI::App* command, WatchFilterOptions* options);

/// The filter they stand for, of all kinds. Errors: `InvalidArgument` for what makes no sense.
absl::StatusOr<MapFilter> ReadWatchFilter(const WatchFilterOptions& options,
                                          const ClassNames& classes);

}  // namespace steadymap
