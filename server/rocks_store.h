#pragma once

#include <atomic>
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
#include <rocksdb/write_batch.h>

#include "server/store.h"
#include "server/store_database.h"
#include "server/store_records.h"
#include "server/write_turns.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {

/// The store in RocksDB. Private to the server: everybody else uses `Store`.
///
/// In memory it keeps each map's record and heads, a few hundred bytes a map; they change after the
/// disk did.
class RocksStore final : public Store {
 public:
  /// `Store::Open` with a file system to put faults in; null: the real one.
  static absl::StatusOr<std::unique_ptr<RocksStore>> Open(const std::filesystem::path& folder,
                                                          const StoreOptions& options,
                                                          rocksdb::Env* environment);

  absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) override;
  absl::Status UpdateMap(const MapRecord& record) override;
  absl::Status DeleteMap(MapKey map) override;
  absl::StatusOr<std::vector<MapRecord>> ListMaps() override;
  absl::StatusOr<StoredState> LoadMap(const MapRecord& record) override;
  absl::Status AppendFrames(const std::vector<LogAppend>& appends) override;
  absl::Status CommitRevision(MapKey map, const MapDelta& delta, Timestamp now) override;
  absl::Status ReadLog(MapKey map,
                       MapSequence first,
                       const std::function<absl::Status(LogFrame)>& visit) override;
  absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                   MapSequence first,
                                                   MapSequence last,
                                                   std::size_t limit) override;
  absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                      EventNumber first,
                                                      std::size_t limit) override;
  absl::StatusOr<ChangeList> ReadChanges(MapKey map, Revision from, Revision to) override;
  absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) override;
  absl::Status health() const override;

  /// For tests that damage what is stored.
  StoreDatabase& database_for_test() { return *database_; }

 private:
  /// What is known of a map without reading the disk.
  struct MapEntry {
    MapRecord record;
    storage::v1::LogHead log_head;
    storage::v1::RevisionHead revision_head;
  };

  RocksStore(std::unique_ptr<StoreDatabase> database, const StoreOptions& options);

  /// Reads all map records and heads. A damaged one is marked, not an error.
  absl::Status LoadEntries();
  absl::StatusOr<MapEntry> LoadEntry(MapKey key, const rocksdb::Snapshot* snapshot) const;
  absl::StatusOr<std::map<MapKey, MapName>> LoadNameIndex() const;

  /// A copy of the map's entry. Errors: `NotFound`; `DataLoss` for a quarantined map.
  absl::StatusOr<MapEntry> Find(MapKey map) const;

  /// Errors: `ResourceExhausted` with reason `DISK_LOW`.
  absl::Status CheckDisk() const;

  /// Checks one append and puts it into `batch`; `*head` becomes the map's new head.
  absl::Status PutAppend(const LogAppend& append,
                         storage::v1::LogHead* head,
                         rocksdb::WriteBatch* batch) const;

  /// Puts a commit into `batch`; `head` is the map's new one.
  void PutCommit(MapKey map,
                 const MapDelta& delta,
                 const storage::v1::RevisionHead& head,
                 rocksdb::WriteBatch* batch) const;

  /// Puts events into `batch`, numbered from `first` on.
  void PutEvents(MapKey map,
                 const std::vector<ObjectEvent>& events,
                 EventNumber first,
                 rocksdb::WriteBatch* batch) const;

  /// Puts a sealed record into `batch`.
  void PutSealed(Family family,
                 const std::string& key,
                 const google::protobuf::MessageLite& record,
                 rocksdb::WriteBatch* batch) const;

  /// Calls `visit` for every value of a map in `snapshot`, until it returns an error.
  using RecordVisitor = std::function<absl::Status(const ValuePlace&, std::string_view)>;
  absl::Status ForEachRecord(Family family,
                             MapKey map,
                             const rocksdb::Snapshot* snapshot,
                             const RecordVisitor& visit) const;

  /// All sessions, and the volumes, objects and free space, of a map in `snapshot`.
  absl::Status LoadSessions(MapKey map,
                            const rocksdb::Snapshot* snapshot,
                            StoredState* state) const;
  absl::Status LoadContent(MapKey map,
                           const rocksdb::Snapshot* snapshot,
                           MapSnapshot* content) const;

  /// The parts of a trim: each puts what goes into `batch`. `entry` is the map as it stands.
  absl::Status TrimLog(const MapEntry& entry,
                       MapSequence last,
                       Timestamp now,
                       rocksdb::WriteBatch* batch,
                       std::uint64_t* dropped_bytes) const;
  absl::Status TrimChangeLists(const MapEntry& entry,
                               const TrimBounds& bounds,
                               rocksdb::WriteBatch* batch) const;
  absl::Status TrimEvents(const MapEntry& entry, rocksdb::WriteBatch* batch) const;
  absl::Status TrimSessions(MapKey map, Timestamp forget_before, rocksdb::WriteBatch* batch) const;

  /// Packed bytes of all frames before `sequence`, whose pose must be there unless it lies beyond
  /// the head.
  absl::StatusOr<std::uint64_t> BytesBefore(const MapEntry& entry, MapSequence sequence) const;

  /// The first frame from `first` on that retention wants, or the one after `last`.
  absl::StatusOr<MapSequence> FindLogCut(const MapEntry& entry,
                                         MapSequence first,
                                         MapSequence last,
                                         Timestamp now) const;

  /// The number in the first key of `map` in `log`, `pose` or `event`; none if there is none.
  absl::StatusOr<std::optional<std::uint64_t>> FirstNumber(Family family, MapKey map) const;

  std::unique_ptr<StoreDatabase> database_;
  const StoreOptions options_;
  std::atomic<std::uint64_t> unreclaimed_bytes_ = 0;  ///< Trimmed from the log, still on disk.
  WriteTurns append_turns_;  ///< Log, poses, sessions, map records. Key 0: creation of maps.
  WriteTurns commit_turns_;  ///< Leaves, change lists, revisions. Taken after `append_turns_`.

  mutable absl::Mutex mutex_;
  std::map<MapKey, MapEntry> entries_ ABSL_GUARDED_BY(mutex_);
  std::map<MapName, MapKey> names_ ABSL_GUARDED_BY(mutex_);
  MapKey next_key_ ABSL_GUARDED_BY(mutex_){1};
};

}  // namespace steadymap
