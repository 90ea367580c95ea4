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

/// What became of a log.
struct SalvagedLog {
  MapSequence first_entry;  ///< The oldest entry; 0: the log holds nothing.
  MapSequence head;         ///< The newest entry; 0 likewise.
  std::uint64_t first_group = 0;
  std::uint64_t last_group = 0;
  std::vector<MapSequence> lost;     ///< Entries that could not be read; nothing stands for them.
  std::vector<std::string> remarks;  ///< Sentences for the operator.
};

/// Writes the log in `from`, of a map that is not open, to the folder `to`, which is made: whole
/// files as they are, damaged ones anew from the records that can still be read. An entry that is
/// lost, and `skip_entry`, are replaced by one without effect, so that those behind keep their
/// numbers. Of a group without its end nothing is known to have been acknowledged: at the end of
/// the log it is dropped.
/// Errors: as `PosixFile`; `NotFound` if `skip_entry` is not in the log.
absl::StatusOr<SalvagedLog> SalvageLog(const std::filesystem::path& from,
                                       const std::filesystem::path& to,
                                       MapKey map,
                                       std::optional<MapSequence> skip_entry);

}  // namespace steadymap
