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
/// sent them, in files of about the same size (`log_segment.h`). What is integrated is dropped file
/// by file.
///
/// `Append` and `Drop` are for one thread at a time; everything else for any thread.
class EntryLog {
 public:
  /// What the map's database knows of the log: more than the log itself where files were dropped.
  struct Known {
    MapSequence head;         ///< The log ends here at least.
    Revision revision;        ///< Entries up to here are integrated.
    std::uint64_t group = 0;  ///< The sessions of the groups up to here are in the database.
  };

  /// What opening found behind what was known.
  struct Found {
    std::map<SessionName, SessionRecord> sessions;  ///< The newest record of each.
    std::vector<LogEntry> classes;                  ///< The entries of this kind, not integrated.
    MapUptime uptime{0};                            ///< Of the last group that was read.
  };

  /// Opens the log in `folder`, which is made if need be. What a crash left of a group that was
  /// never acknowledged is cut off, and the log says so. `found` is filled. `read_only`: nothing is
  /// cut or made, and nothing can be appended.
  /// Errors: `DataLoss` with reason `CHECKSUM` for a damaged file, or one that is missing.
  static absl::StatusOr<std::unique_ptr<EntryLog>> Open(const std::filesystem::path& folder,
                                                        MapKey map,
                                                        const Known& known,
                                                        std::uint64_t segment_bytes,
                                                        bool read_only,
                                                        Found* found);

  /// Makes entries and sessions durable; see `Store::Append`. Errors: `FailedPrecondition` if the
  /// entries do not follow the head; `ResourceExhausted` with reason `DISK_LOW`; `Unavailable` with
  /// reason `STORE_READ_ONLY`, then and ever after.
  absl::Status Append(const LogAppend& append) ABSL_LOCKS_EXCLUDED(mutex_);

  /// See `Store::ReadLog`. Entries from `needed` on must be there.
  absl::Status Read(MapSequence first,
                    MapSequence needed,
                    const std::function<absl::Status(LogEntry)>& visit) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Entries and groups that the map's database can do without.
  struct Done {
    MapSequence entries;       ///< Integrated up to here, and the database knows that they were.
    std::uint64_t groups = 0;  ///< Their sessions are in the database up to here.
  };

  /// Removes the oldest files that are done with, as long as the log holds more than `kept_bytes`
  /// or the oldest file's youngest entry is `max_age` old.
  absl::Status Drop(const Done& done,
                    std::uint64_t kept_bytes,
                    MapUptime uptime,
                    std::chrono::seconds max_age) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest entry; 0: there was none ever.
  MapSequence head() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest group.
  std::uint64_t group() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Bytes of all files.
  std::uint64_t bytes() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// OK, or the error after which nothing can be appended.
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
  /// Of the newest file, for `Append` and `Drop`; none: the next append makes one.
  std::optional<LogSegmentWriter> writer_;

  mutable absl::Mutex mutex_;
  std::vector<Segment> segments_ ABSL_GUARDED_BY(mutex_);  ///< In their order.
  MapSequence head_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t group_ ABSL_GUARDED_BY(mutex_) = 0;
  MapUptime newest_uptime_ ABSL_GUARDED_BY(mutex_){0};
  absl::Status health_ ABSL_GUARDED_BY(mutex_);
};

/// A log entry as its record's payload holds it, and back. Errors of the latter: `DataLoss`.
/// `header` keeps the bytes that are not the entry's own; the payload's parts point into both.
std::vector<std::string_view> PackEntry(const LogEntry& entry, std::string* header);
absl::StatusOr<LogEntry> UnpackEntry(FoundRecord record);

}  // namespace steadymap
