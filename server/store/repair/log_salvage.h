#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "core/types/identifiers.h"

namespace steadymap {

/// The result of the salvage of a log.
struct SalvagedLog {
  MapSequence first_entry;  ///< The oldest entry; 0: the log is empty.
  MapSequence head;         ///< The newest entry; 0: the log is empty.
  std::uint64_t first_group = 0;
  std::uint64_t last_group = 0;
  /// Entries that could not be read. Each is replaced by an entry without effect.
  std::vector<MapSequence> lost;
  std::vector<std::string> remarks;  ///< Sentences for the operator.
};

/// Copies the log in `from`, of a map that is not open, to the new folder `to`. Intact files are
/// copied unchanged. Damaged files are rebuilt from their readable records. A lost entry, and
/// `skip_entry`, is replaced by an entry without effect, so that later entries keep their numbers.
/// An incomplete group at the end of the log is dropped, because it may never have been
/// acknowledged. Errors: as `PosixFile`; `NotFound` if `skip_entry` is not in the log.
absl::StatusOr<SalvagedLog> SalvageLog(const std::filesystem::path& from,
                                       const std::filesystem::path& to,
                                       MapKey map,
                                       std::optional<MapSequence> skip_entry);

}  // namespace steadymap
