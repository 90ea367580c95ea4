#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

namespace steadymap {

/// A write-ahead log whose last write was torn by a power cut.
struct TornLog {
  std::filesystem::path file;
  std::uint64_t size = 0;       ///< Size of the file in bytes.
  std::uint64_t whole_end = 0;  ///< End of the last complete record.
};

/// Detects a torn last write in RocksDB's write-ahead log in `folder`, left by a power cut; none if
/// there is no torn write.
///
/// Every write is one record of the log, synced before the next write begins. A power cut may leave
/// the last record with its full length but without some of its disk sectors, which then read as
/// zeros. RocksDB, configured to refuse damage, would refuse this record too, although the write
/// was never acknowledged as durable. This function finds the first broken record. It reports the
/// log as torn there if all of these hold: the log is the newest one, no later record begins behind
/// the broken one, and at least one sector is missing. Any other damage is real and is left for
/// RocksDB to detect.
///
/// Cost: one pass over the newest log, about 1 ms per megabyte. Errors: `Internal` if the log
/// cannot be read.
absl::StatusOr<std::optional<TornLog>> FindTornLog(const std::filesystem::path& folder);

/// Truncates a torn last write found by `FindTornLog`, and logs a warning. Call before the database
/// is opened. Errors: `Internal` if the log cannot be read or truncated.
absl::Status CutTornLog(const std::filesystem::path& folder);

/// Returns the offset at which a torn write-ahead log with content `log` must be truncated. Returns
/// none if the log is complete, ends within a record (which RocksDB drops itself), or is damaged in
/// another way.
std::optional<std::uint64_t> FindTornEnd(std::string_view log);

}  // namespace steadymap
