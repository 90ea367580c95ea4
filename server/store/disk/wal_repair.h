#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// A write-ahead log whose last write a power cut tore.
struct TornLog {
  std::filesystem::path file;
  std::uint64_t size = 0;       ///< Of the file.
  std::uint64_t whole_end = 0;  ///< Behind the last record that is whole.
};

/// Finds what a power cut left of the last write to RocksDB's write-ahead log in `folder`; none if
/// there is no such rest.
///
/// Every write is one record of the log, synced before the next begins. A power cut may leave the
/// last one with its length but without some of its disk sectors, which then read as zeros.
/// RocksDB, told to refuse damage, would refuse this too, although nobody was ever told that the
/// write is durable. So this looks for the first broken record, and calls the log torn there if all
/// of these hold: it is the newest log, no later write begins behind it, and it lacks at least one
/// sector. Anything else is real damage and is left for RocksDB to find.
///
/// Cost: one pass over the newest log, about 1 ms a megabyte. Errors: `Internal` if the log cannot
/// be read.
absl::StatusOr<std::optional<TornLog>> FindTornLog(const std::filesystem::path& folder);

/// Cuts such a rest off, and says so in the log. Call before the database is opened. Errors:
/// `Internal` if the log cannot be read or cut.
absl::Status CutTornLog(const std::filesystem::path& folder);

/// Where `log`, the content of a write-ahead log, has to be cut; none if it is whole, ends within a
/// record (which RocksDB drops on its own), or is damaged otherwise.
std::optional<std::uint64_t> FindTornEnd(std::string_view log);

}  // namespace steadymap
