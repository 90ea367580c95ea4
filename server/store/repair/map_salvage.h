#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// The map to repair, and the options.
struct SalvageOptions {
  std::filesystem::path data_dir;
  MapName map;
  std::optional<MapSequence> skip_entry{};  ///< Entry of the log to exclude from the map.
  std::filesystem::path output{};           ///< Folder for the repaired map; empty: into the store.
};

/// The result of a salvage. `remarks` are sentences for the operator.
struct SalvageReport {
  std::vector<std::string> remarks;
  std::filesystem::path repaired;   ///< Folder of the repaired map.
  std::filesystem::path old_files;  ///< Folder with the old files.
};

/// Repairs one map of a store that is not open in a server.
///
/// The log is kept except for unreadable parts (`SalvageLog`). An intact database is kept. A
/// damaged database is rebuilt from the log, with an identical result, if the log reaches back to
/// the first entry; otherwise from its readable tables; otherwise the map starts from the oldest
/// entry of the log. The server integrates the log when it opens the map. A map whose database was
/// not kept gets a new incarnation: its watchers start from a snapshot.
///
/// The old files are never changed or deleted: without `output` they are moved to `salvaged/KEY-N`
/// in the data folder. Errors: `FailedPrecondition` if a server holds the folder or `output`
/// exists; `NotFound` if the map or the entry does not exist; `DataLoss` if both copies of the
/// map's record are damaged, because a map cannot be rebuilt without its configuration; as
/// `PosixFile`.
absl::StatusOr<SalvageReport> SalvageMap(const SalvageOptions& options);

}  // namespace steadymap
