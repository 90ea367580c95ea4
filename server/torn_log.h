#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include <absl/status/status.h>

namespace steadymap {

/// Cuts off what a power cut left of the last write to RocksDB's write-ahead log in `folder`.
///
/// Every write is one record of the log, synced before the next begins. A power cut may leave the
/// last one with its length but without some of its disk sectors, which then read as zeros.
/// RocksDB, told to refuse damage, would refuse this too, although nobody was ever told that the
/// write is durable. So this looks for the first broken record, and cuts the log there if all of
/// these hold: it is the newest log, no later write begins behind it, and it lacks at least one
/// sector. Anything else is real damage and is left for RocksDB to find. Says in the log what it
/// cut.
///
/// Call before the database is opened. Cost: one pass over the newest log, about 1 ms a megabyte.
/// Errors: `Internal` if the log cannot be read or cut.
absl::Status CutTornLog(const std::filesystem::path& folder);

/// Where `log`, the content of a write-ahead log, has to be cut; none if it is whole, ends within a
/// record (which RocksDB drops on its own), or is damaged otherwise.
std::optional<std::uint64_t> FindTornEnd(std::string_view log);

}  // namespace steadymap
