#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <absl/synchronization/notification.h>
#include <rocksdb/env.h>

#include "server/store/disk/disk_space_gate.h"
#include "server/store/disk/folder_lock.h"
#include "server/store/disk/mirrored_file.h"
#include "server/store/map/map_database.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The store on disk. Private to the server: everybody else uses `Store`.
///
/// The folder holds `lock`, `schema`, `catalog` (which maps there are), and `maps/KEY/` for each
/// map (`map_folder.h`). In memory it keeps each map's record, and an open map's database.
class RocksStore final : public Store {
 public:
  /// What a test may put in place of the machine's own.
  struct Platform {
    std::shared_ptr<rocksdb::FileSystem> file_system = rocksdb::FileSystem::Default();
    /// Free bytes for the daemon's user on a folder's disk.
    std::function<absl::StatusOr<std::uint64_t>(const std::filesystem::path&)> free_disk_bytes =
        FreeDiskBytes;
  };

  /// `Store::Open` on another platform.
  static absl::StatusOr<std::unique_ptr<RocksStore>> Open(const std::filesystem::path& folder,
                                                          const StoreOptions& options,
                                                          const Platform& platform);

  /// Waits for everybody who still reads a map.
  ~RocksStore() override;

  absl::StatusOr<MapRecord> CreateMap(const MapRecord& record) override;
  absl::Status UpdateMap(const MapRecord& record) override;
  absl::Status DeleteMap(MapKey map) override;
  absl::StatusOr<std::vector<MapRecord>> ListMaps() override;
  absl::StatusOr<StoredState> LoadMap(const MapRecord& record) override;
  absl::Status Append(const LogAppend& append) override;
  absl::StatusOr<CommitMark> CommitRevision(MapKey map,
                                            const MapDelta& delta,
                                            const CommitDetails& details) override;
  absl::Status ReadLog(MapKey map,
                       MapSequence first,
                       const std::function<absl::Status(LogEntry)>& visit) override;
  absl::StatusOr<std::vector<FramePose>> ReadPoses(MapKey map,
                                                   MapSequence first,
                                                   MapSequence last,
                                                   std::size_t limit) override;
  absl::StatusOr<std::vector<StoredEvent>> ReadEvents(MapKey map,
                                                      EventNumber first,
                                                      std::size_t limit) override;
  absl::StatusOr<ChangeList> ReadChanges(MapKey map, CommitMark from, Revision to) override;
  absl::Status Trim(const MapRecord& map, const TrimBounds& bounds) override;
  absl::Status health(MapKey map) const override;
  absl::Status CheckDisk() const override;

  void Reclaim() override { RemoveDeleted(); }

  bool IsWaitingForDisk() const override;
  void StopWaitingForDisk() override;

  /// For tests that damage what is stored; the map must be open.
  StateDatabase& state_for_test(MapKey map);

 private:
  /// A map as the store holds it.
  struct MapEntry {
    MapRecord record;
    std::shared_ptr<MapDatabase> database;  ///< Null until it is opened.
    /// Notified once the last user of the database that was open has let go of it; null: none was.
    std::shared_ptr<absl::Notification> closed;
    std::shared_ptr<WriterMutex> opening = std::make_shared<WriterMutex>();
  };

  RocksStore(FolderLock lock,
             std::filesystem::path folder,
             const StoreOptions& options,
             const Platform& platform);

  static absl::StatusOr<std::uint64_t> FreeDiskBytes(const std::filesystem::path& folder);
  absl::Status LoadCatalog();
  void RemoveDeleted();
  absl::Status WriteCatalog() ABSL_EXCLUSIVE_LOCKS_REQUIRED(catalog_mutex_);

  /// The database of an open map. Errors: `NotFound`; `DataLoss` for a quarantined map.
  absl::StatusOr<std::shared_ptr<MapDatabase>> Find(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The database of a map, opened if it is not open or has failed.
  absl::StatusOr<std::shared_ptr<MapDatabase>> OpenDatabase(const MapRecord& record)
      ABSL_LOCKS_EXCLUDED(mutex_);

  MapDatabase::Dependencies DatabaseDependencies() const;

  const FolderLock lock_;
  const std::filesystem::path folder_;
  const StoreOptions options_;
  const Platform platform_;
  const std::shared_ptr<DiskSpaceGate> gate_;
  const std::unique_ptr<rocksdb::Env> environment_;
  const SharedResources shared_;
  const MirroredFile catalog_file_;

  /// Whoever creates, changes or deletes a map; held while the disk syncs, by nobody who is in a
  /// hurry.
  absl::Mutex catalog_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);

  mutable absl::Mutex mutex_;
  std::map<MapKey, MapEntry> maps_ ABSL_GUARDED_BY(mutex_);
  std::map<MapName, MapKey> names_ ABSL_GUARDED_BY(mutex_);
  MapKey next_key_ ABSL_GUARDED_BY(mutex_){1};
  /// Maps that are deleted, whose folders go once nobody uses them.
  std::list<std::pair<MapKey, std::shared_ptr<absl::Notification>>> deleted_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
