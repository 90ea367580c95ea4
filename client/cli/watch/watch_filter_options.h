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

/// The watched part of a map, as given on the command line.
struct WatchFilterOptions {
  std::vector<std::string> boxes;
  std::vector<std::string> classes;    ///< Ids or names.
  std::vector<std::uint64_t> objects;  ///< 0 is the background.
};

/// Adds the options that set `options`.
void AddWatchFilterOptions(CLI::App* command, WatchFilterOptions* options);

/// Returns the filter described by the options, for all kinds. Errors: `InvalidArgument` for
/// invalid options.
absl::StatusOr<MapFilter> ReadWatchFilter(const WatchFilterOptions& options,
                                          const ClassNames& classes);

}  // namespace steadymap
