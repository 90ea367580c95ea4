#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include "server/store/database/state_database.h"
#include "server/store/database/writer_mutex.h"
#include "server/store/log/entry_log.h"
#include "server/store/map/record_batch.h"
#include "server/store/model/store.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {

/// The durable storage of one open map, in its own folder: the entry log, in which entries become
/// durable (`log/`), the database with the integrated map (`state/`), and the note of the entry
/// that is being integrated (`note`). Private to the store. `Store` documents the functions.
class MapDatabase {
 public:
  /// The dependencies of a map's database; they must outlive it.
  struct Dependencies {
    const SharedResources* shared = nullptr;
    const StoreOptions* options = nullptr;
    /// Returns the bytes available to the daemon's user on the disk of the folder.
    std::function<absl::StatusOr<std::uint64_t>()> free_disk_bytes;
    bool read_only = false;  ///< True: nothing in the folder is changed, for inspection tools.
  };

  /// Creates an empty database in the existing folder `folder`, and syncs it.
  static absl::Status Create(const std::filesystem::path& folder, const Dependencies& dependencies);

  /// Opens the database in `folder`. If the disk has too little free space for RocksDB to start,
  /// the map is opened read-only and `health()` returns the reason. Errors: `DataLoss` with reason
  /// `CHECKSUM` for damaged or missing files.
  static absl::StatusOr<std::unique_ptr<MapDatabase>> Open(const std::filesystem::path& folder,
                                                           const MapRecord& record,
                                                           const Dependencies& dependencies);

  MapDatabase(const MapDatabase&) = delete;
  MapDatabase& operator=(const MapDatabase&) = delete;

  absl::StatusOr<StoredState> Load() const;
  absl::Status Append(const LogAppend& append);
  absl::StatusOr<CommitMark> Commit(const MapDelta& delta, const CommitDetails& details);
  absl::Status ReadLog(MapSequence first, const std::function<absl::Status(LogEntry)>& visit) const;
  absl::StatusOr<std::vector<FramePose>> ReadPoses(MapSequence first,
                                                   MapSequence last,
                                                   std::size_t limit) const;
  absl::StatusOr<std::vector<StoredEvent>> ReadEvents(EventNumber first, std::size_t limit) const;
  absl::StatusOr<ChangeList> ReadChanges(CommitMark from, Revision to) const;

  /// Trims as `Store::Trim` does. `retention` contains the map's current limits.
  absl::Status Trim(const MapRecord& retention, const TrimBounds& bounds);

  absl::Status health() const;

  /// Returns the database, for tests that damage the stored data.
  StateDatabase& state_for_test() { return *state_; }

 private:
  /// A session whose newest record is in the log but not in the database yet.
  struct UnsavedSession {
    SessionRecord record;
    std::uint64_t group = 0;  ///< Group of the log that contains the record.
  };

  /// The progress of the map, kept in memory. Updated after the disk.
  struct Progress {
    storage::v1::Head head;  ///< As stored in the database.
    MapSequence durable_head;
    std::uint64_t group = 0;  ///< Newest group of the log.
    std::map<SessionName, UnsavedSession> unsaved_sessions;
    std::size_t stored_classes = 0;            ///< Number of added classes in the database.
    std::vector<SemanticClass> added_classes;  ///< Classes added by entries up to `durable_head`.
  };

  MapDatabase(const MapRecord& record, const Dependencies& dependencies);

  absl::Status OpenState(const std::filesystem::path& folder);
  absl::Status OpenLog(const std::filesystem::path& folder);
  absl::Status CheckNote() const;
  Progress progress() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns OK, or `DISK_LOW` if fewer bytes than `needed` are free.
  absl::Status CheckFree(std::uint64_t needed) const;

  /// Adds to `records` the sessions that are not in the database yet, and the head, which then
  /// records the end of the log.
  void PutProgress(const Progress& progress, storage::v1::Head* head, RecordBatch* records) const;
  void DropSavedSessions(const storage::v1::Head& head) ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Status TrimState(const TrimBounds& bounds);

  /// The key, name and configuration of the map at the time it was opened.
  const MapRecord record_;
  const Dependencies dependencies_;
  std::unique_ptr<StateDatabase> state_;
  std::unique_ptr<EntryLog> log_;
  std::shared_ptr<IntegrationNote> note_;
  WriterMutex append_mutex_;
  WriterMutex commit_mutex_;

  mutable absl::Mutex mutex_;
  Progress progress_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
