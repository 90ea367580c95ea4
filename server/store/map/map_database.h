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

/// The durable side of one open map: the log in which its entries become durable (`log/`), the
/// database of what was made of them (`state/`), and the note of what is being integrated (`note`),
/// in a folder of its own. Private to the store; see `Store` for what the functions promise.
class MapDatabase {
 public:
  /// What a map's database needs; all of it outlives it.
  struct Dependencies {
    const SharedResources* shared = nullptr;
    const StoreOptions* options = nullptr;
    /// Free bytes for the daemon's user on the folder's disk.
    std::function<absl::StatusOr<std::uint64_t>()> free_disk_bytes;
    bool read_only = false;  ///< Whether to change nothing in the folder, for tools that look.
  };

  /// Makes an empty database in `folder`, which exists; on disk when it returns.
  static absl::Status Create(const std::filesystem::path& folder, const Dependencies& dependencies);

  /// Opens the database in `folder`. With too little room on the disk for RocksDB to start it is
  /// opened for reading alone, which `health()` then says.
  /// Errors: `DataLoss` with reason `CHECKSUM` for what is damaged or missing.
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

  /// `retention` holds the map's present bounds.
  absl::Status Trim(const MapRecord& retention, const TrimBounds& bounds);

  absl::Status health() const;

  /// For tests that damage what is stored.
  StateDatabase& state_for_test() { return *state_; }

 private:
  /// A session whose newest record is in the log, not in the database yet.
  struct UnsavedSession {
    SessionRecord record;
    std::uint64_t group = 0;  ///< Of the log: where the record stands.
  };

  /// What is kept in memory of how far the map has come; it changes after the disk did.
  struct Progress {
    storage::v1::Head head;  ///< As it is in the database.
    MapSequence durable_head;
    std::uint64_t group = 0;  ///< The log's newest.
    std::map<SessionName, UnsavedSession> unsaved_sessions;
    std::size_t stored_classes = 0;            ///< Added ones that the database knows.
    std::vector<SemanticClass> added_classes;  ///< Up to `durable_head`.
  };

  MapDatabase(const MapRecord& record, const Dependencies& dependencies);

  absl::Status OpenState(const std::filesystem::path& folder);
  absl::Status OpenLog(const std::filesystem::path& folder);
  absl::Status CheckNote() const;
  Progress progress() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// OK, or `DISK_LOW` if fewer bytes are free than `needed`.
  absl::Status CheckFree(std::uint64_t needed) const;

  /// Adds the sessions that the database does not know yet and the head, which then records how
  /// far the log goes.
  void PutProgress(const Progress& progress, storage::v1::Head* head, RecordBatch* records) const;
  void ForgetSaved(const storage::v1::Head& head) ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Status TrimState(const TrimBounds& bounds);

  const MapRecord record_;  ///< As it was when the map was opened: its key, name and configuration.
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
