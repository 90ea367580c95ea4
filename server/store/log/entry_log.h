#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include "server/store/log/log_segment.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The log of one map: its entries in the order of their sequence numbers, and the sessions that
/// sent them, in files of similar size (`log_segment.h`). Integrated entries are dropped in whole
/// files.
///
/// Thread-safe, except that only one thread at a time may call `Append` or `Drop`.
class EntryLog {
 public:
  /// The state of the log that is recorded in the map's database. It covers more than the log
  /// itself where files were dropped.
  struct Known {
    MapSequence head;         ///< The newest entry of the log is at least this one.
    Revision revision;        ///< Entries up to here are integrated.
    std::uint64_t group = 0;  ///< The sessions of groups up to here are in the database.
  };

  /// The records found in the log that are newer than `Known`.
  struct Found {
    std::map<SessionName, SessionRecord> sessions;  ///< The newest record of each session.
    std::vector<LogEntry> classes;  ///< Entries of kind `kClasses` that are not integrated.
    MapUptime uptime{0};            ///< Uptime of the last group that was read.
  };

  /// Opens the log in `folder`, and creates the folder if it does not exist. A group that a crash
  /// interrupted and that was never acknowledged is truncated, and a warning is logged. Fills
  /// `found`. `read_only`: nothing is truncated or created, and appends fail. Errors: `DataLoss`
  /// with reason `CHECKSUM` for a damaged or missing file.
  static absl::StatusOr<std::unique_ptr<EntryLog>> Open(const std::filesystem::path& folder,
                                                        MapKey map,
                                                        const Known& known,
                                                        std::uint64_t segment_bytes,
                                                        bool read_only,
                                                        Found* found);

  /// Makes entries and sessions durable; see `Store::Append`. Errors: `FailedPrecondition` if the
  /// entries do not follow the head; `ResourceExhausted` with reason `DISK_LOW`; `Unavailable` with
  /// reason `STORE_READ_ONLY`, and the same error for every later append.
  absl::Status Append(const LogAppend& append) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Reads entries, see `Store::ReadLog`. Entries from `needed` on must exist.
  absl::Status Read(MapSequence first,
                    MapSequence needed,
                    const std::function<absl::Status(LogEntry)>& visit) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// The entries and groups that the map's database no longer needs from the log.
  struct Done {
    MapSequence entries;       ///< Entries up to here are integrated in the stored state.
    std::uint64_t groups = 0;  ///< Sessions of groups up to here are in the database.
  };

  /// Removes the oldest files that contain only `done` entries and groups, while the log is larger
  /// than `kept_bytes` or the newest entry of the oldest file is at least `max_age` old.
  absl::Status Drop(const Done& done,
                    std::uint64_t kept_bytes,
                    MapUptime uptime,
                    std::chrono::seconds max_age) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the newest entry; 0: no entry was ever appended.
  MapSequence head() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the number of the newest group.
  std::uint64_t group() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the total size of all files in bytes.
  std::uint64_t bytes() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns OK, or the error that prevents appends.
  absl::Status health() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// A file of the log.
  struct Segment {
    SegmentStart start;
    std::uint64_t bytes = 0;
  };

  EntryLog(std::filesystem::path folder, MapKey map, std::uint64_t segment_bytes);

  absl::Status ListSegments();
  absl::Status ScanTail(const Known& known, bool read_only, Found* found);
  absl::Status CutTornGroup(const SegmentScan& scan);
  absl::Status BeginSegment(MapUptime uptime);
  absl::Status CheckSequence(const LogAppend& append) const ABSL_LOCKS_EXCLUDED(mutex_);
  std::filesystem::path PathOf(const SegmentStart& start) const;

  const std::filesystem::path folder_;
  const MapKey map_;
  const std::uint64_t segment_bytes_;
  /// Writes to the newest file. Used by `Append` and `Drop`. None: the next append creates a file.
  std::optional<LogSegmentWriter> writer_;

  mutable absl::Mutex mutex_;
  std::vector<Segment> segments_ ABSL_GUARDED_BY(mutex_);  ///< In log order.
  MapSequence head_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t group_ ABSL_GUARDED_BY(mutex_) = 0;
  MapUptime newest_uptime_ ABSL_GUARDED_BY(mutex_){0};
  absl::Status health_ ABSL_GUARDED_BY(mutex_);
};

/// Converts a log entry to the payload of its record. `header` stores the bytes that are not part
/// of the entry itself; the returned parts point into `entry` and `header`. `UnpackEntry` converts
/// back; its error is `DataLoss`.
std::vector<std::string_view> PackEntry(const LogEntry& entry, std::string* header);
absl::StatusOr<LogEntry> UnpackEntry(FoundRecord record);

}  // namespace steadymap
