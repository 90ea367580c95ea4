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

/// The implementation of `Store` on disk. Only the store and its tests use it directly; all other
/// code uses `Store`.
///
/// The data folder contains `lock`, `schema`, `catalog` (the list of maps), and `maps/KEY/` for
/// each map (`map_folder.h`). In memory, the store keeps the record of each map and the
/// `MapDatabase` of each open map.
class RocksStore final : public Store {
 public:
  /// The parts of the operating system that a test may replace.
  struct Platform {
    std::shared_ptr<rocksdb::FileSystem> file_system = rocksdb::FileSystem::Default();
    /// Returns the bytes available to the daemon's user on the disk of a folder.
    std::function<absl::StatusOr<std::uint64_t>(const std::filesystem::path&)> free_disk_bytes =
        FreeDiskBytes;
  };

  /// Opens a store as `Store::Open` does, with the given platform.
  static absl::StatusOr<std::unique_ptr<RocksStore>> Open(const std::filesystem::path& folder,
                                                          const StoreOptions& options,
                                                          const Platform& platform);

  /// Waits until no thread uses a map's database any more.
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

  /// Returns the database of an open map, for tests that damage the stored data.
  StateDatabase& state_for_test(MapKey map);

 private:
  /// A map and its database.
  struct MapEntry {
    MapRecord record;
    std::shared_ptr<MapDatabase> database;  ///< Null until the map is opened.
    /// Notified when the last user of the most recently opened database releases it; null: no
    /// database was opened yet.
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

  /// Returns the database of an open map. Errors: `NotFound`; `DataLoss` for a quarantined map.
  absl::StatusOr<std::shared_ptr<MapDatabase>> Find(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the database of a map. Opens it if it is not open or has failed.
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

  /// Serialises creation, update and deletion of maps. Held during disk syncs, so never acquired on
  /// the upload path.
  absl::Mutex catalog_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);

  mutable absl::Mutex mutex_;
  std::map<MapKey, MapEntry> maps_ ABSL_GUARDED_BY(mutex_);
  std::map<MapName, MapKey> names_ ABSL_GUARDED_BY(mutex_);
  MapKey next_key_ ABSL_GUARDED_BY(mutex_){1};
  /// Deleted maps. The folder of each is removed when its database is no longer in use.
  std::list<std::pair<MapKey, std::shared_ptr<absl::Notification>>> deleted_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
