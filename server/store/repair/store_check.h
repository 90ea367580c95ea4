#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "server/store/model/store.h"

namespace steadymap {

/// What a check found of one map.
struct MapFindings {
  MapKey key;
  MapName name;  ///< `lost/map-KEY` where nothing says it any more.
  std::filesystem::path folder;
  std::vector<std::string> problems;  ///< One sentence each, with the file; empty: all is well.
};

/// What a check found of a store.
struct StoreFindings {
  std::vector<std::string> problems;  ///< Of the files that belong to no map.
  std::vector<MapFindings> maps;      ///< By rising key.

  bool ok() const;
};

/// Reads every file of a store that no server has open, and changes none of them: the checksums of
/// all log files, of both copies of each small file, and of all tables and values of the databases;
/// then each map is loaded as a server would. `only`: of that map alone.
/// Errors: `FailedPrecondition` if a server holds the folder; `NotFound` if it holds no store, or
/// has no map of that name. Cost: one pass over all bytes; the memory of the largest map.
absl::StatusOr<StoreFindings> CheckStore(const std::filesystem::path& data_dir,
                                         const std::optional<MapName>& only);

/// The maps that have a folder in `data_dir`, with what is wrong with the files that name them.
/// Changes nothing; the caller holds the folder's lock. Errors: as `CheckStore`.
absl::StatusOr<StoreFindings> FindMaps(const std::filesystem::path& data_dir);

/// What is wrong with the database in `folder`, of a map that is not open: OK, or the first damage.
absl::Status CheckDatabase(const std::filesystem::path& folder);

/// The files of the log in `folder`, in the order of their groups.
std::vector<std::filesystem::path> LogFiles(const std::filesystem::path& folder);

}  // namespace steadymap
