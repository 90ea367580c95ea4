#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/store/model/store.h"

namespace steadymap {

/// The problems found in one map.
struct MapCheckResult {
  MapKey key;
  MapName name;  ///< `lost/map-KEY` if the name is lost.
  std::filesystem::path folder;
  std::vector<std::string> problems;  ///< One sentence each, with the file; empty: no problem.
};

/// The problems found in a store.
struct StoreCheckResult {
  std::vector<std::string> problems;  ///< Problems in files that belong to no map.
  std::vector<MapCheckResult> maps;   ///< In ascending order of keys.

  bool ok() const;
};

/// Reads every file of a store that is not open in a server, and changes none of them. Verifies the
/// checksums of all log files, of both copies of each small file, and of all tables and values of
/// the databases. Then loads each map as a server would. `only`: checks that map alone. Errors:
/// `FailedPrecondition` if a server holds the folder; `NotFound` if the folder contains no store or
/// no map of that name. Cost: one pass over all bytes; the memory of the largest map.
absl::StatusOr<StoreCheckResult> CheckStore(const std::filesystem::path& data_dir,
                                            const std::optional<MapName>& only);

/// Returns the maps with a folder in `data_dir`, and the problems of the catalog, such as a missing
/// folder of a map. Changes nothing. The caller must hold the folder's lock. Errors: as
/// `CheckStore`.
absl::StatusOr<StoreCheckResult> FindMaps(const std::filesystem::path& data_dir);

/// Verifies the database in `folder`, of a map that is not open. Returns OK, or the first damage.
absl::Status CheckDatabase(const std::filesystem::path& folder);

/// Returns the files of the log in `folder`, in the order of their groups.
std::vector<std::filesystem::path> LogFiles(const std::filesystem::path& folder);

}  // namespace steadymap
