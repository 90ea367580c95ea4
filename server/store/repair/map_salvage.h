#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// What is to be repaired, and how.
struct SalvageOptions {
  std::filesystem::path data_dir;
  MapName map;
  std::optional<MapSequence> skip_entry{};  ///< This entry of the log is to have no effect.
  std::filesystem::path output{};  ///< Where to put the repaired map; empty: into the store.
};

/// What a salvage did: sentences for the operator.
struct SalvageReport {
  std::vector<std::string> remarks;
  std::filesystem::path repaired;   ///< The map's folder now.
  std::filesystem::path old_files;  ///< Where its former files are.
};

/// Repairs one map of a store that no server has open.
///
/// The log is kept but for what cannot be read of it (`SalvageLog`). A database that is whole is
/// kept. A damaged one is made anew from the log, which gives the same map, where the log reaches
/// back to the first entry; else from the tables that can be read; else the map begins anew with
/// the oldest entry of the log. The server integrates the log when it opens the map. A map whose
/// database was not kept gets another incarnation: those who watch it start from a snapshot.
///
/// The old files are never changed or deleted: without `output` they move to `salvaged/KEY-N` in
/// the data folder. Errors: `FailedPrecondition` if a server holds the folder; `NotFound` for a map
/// or an entry that is not there; `DataLoss` if both copies of the map's record are damaged:
/// without its configuration a map cannot be made anew; as `PosixFile`.
absl::StatusOr<SalvageReport> SalvageMap(const SalvageOptions& options);

}  // namespace steadymap
