#include "server/store/rocks_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "server/store/disk/free_space.h"
#include "server/store/disk/posix_file.h"
#include "server/store/map_discovery.h"
#include "server/store/store_catalog.h"

namespace steadymap {
namespace {

absl::Status UnknownMap(MapKey map) {
  return MakeError(absl::StatusCode::kNotFound,
                   reason::kNotFound,
                   absl::StrCat("the store has no map with key ", map.value()));
}

absl::Status NotOpen(MapKey map) {
  return MakeError(absl::StatusCode::kNotFound,
                   reason::kNotFound,
                   absl::StrCat("map ", map.value(), " is not open"));
}

/// Adds the name of the map to an error whose message contains only a location.
absl::Status OfMap(const MapRecord& record, const absl::Status& status) {
  return MakeError(
      status.code(),
      ReasonOf(status),
      absl::StrCat("map ", record.name.ToString(), ": ", std::string(status.message())));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> Store::Open(const std::filesystem::path& folder,
                                                   const StoreOptions& options) {
  absl::StatusOr<std::unique_ptr<RocksStore>> store =
      RocksStore::Open(folder, options, RocksStore::Platform());
  if (!store.ok()) return store.status();
  return std::unique_ptr<Store>(*std::move(store));
}

absl::StatusOr<std::unique_ptr<RocksStore>> RocksStore::Open(const std::filesystem::path& folder,
                                                             const StoreOptions& options,
                                                             const Platform& platform) {
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return lock.status();
  if (absl::Status status = CheckSchema(folder, folder / kMapsFolderName); !status.ok())
    return status;
  std::unique_ptr<RocksStore> store(new RocksStore(*std::move(lock), folder, options, platform));
  if (absl::Status status = store->LoadCatalog(); !status.ok()) return status;
  store->RemoveDeleted();
  return store;
}

RocksStore::RocksStore(FolderLock lock,
                       std::filesystem::path folder,
                       const StoreOptions& options,
                       const Platform& platform)
    : lock_(std::move(lock)),
      folder_(std::move(folder)),
      options_(options),
      platform_(platform),
      gate_(std::make_shared<DiskSpaceGate>(platform.file_system)),
      environment_(rocksdb::NewCompositeEnv(gate_)),
      shared_(options_, environment_.get()),
      catalog_file_(folder_ / "catalog") {}

RocksStore::~RocksStore() {
  std::vector<std::shared_ptr<absl::Notification>> closing;
  {
    const absl::MutexLock lock(&mutex_);
    for (auto& [key, entry] : maps_) {
      entry.database.reset();
      if (entry.closed != nullptr) closing.push_back(entry.closed);
    }
    for (const auto& [key, closed] : deleted_) {
      if (closed != nullptr) closing.push_back(closed);
    }
  }
  for (const auto& closed : closing) closed->WaitForNotification();
  RemoveDeleted();
}

absl::Status RocksStore::LoadCatalog() {
  absl::StatusOr<DiscoveredMaps> maps = DiscoverMaps(folder_, catalog_file_);
  if (!maps.ok()) return maps.status();
  const absl::MutexLock lock(&mutex_);
  next_key_ = maps->next_key;
  for (const MapKey key : maps->deleted) deleted_.emplace_back(key, nullptr);
  for (auto& [key, record] : maps->records) {
    names_.emplace(record.name, key);
    maps_[key].record = std::move(record);
  }
  return absl::OkStatus();
}

absl::Status RocksStore::WriteCatalog() {
  StoreCatalog catalog;
  {
    const absl::MutexLock lock(&mutex_);
    catalog.next_key = next_key_;
    for (const auto& [key, entry] : maps_) catalog.maps.push_back({key, entry.record.name});
  }
  return catalog_file_.Write(catalog.Pack());
}

/// Removes the folders of deleted maps whose databases are no longer in use.
void RocksStore::RemoveDeleted() {
  const absl::MutexLock catalog_lock(&catalog_mutex_);
  std::vector<MapKey> unused;
  {
    const absl::MutexLock lock(&mutex_);
    for (const auto& [key, closed] : deleted_) {
      if (closed == nullptr || closed->HasBeenNotified()) unused.push_back(key);
    }
  }
  if (unused.empty()) return;
  // The catalog is written first: a map in the catalog without a folder would be reported as lost.
  absl::Status status = WriteCatalog();
  for (const MapKey key : unused) {
    if (status.ok()) status = MapFolderOf(folder_, key).Remove();
    if (!status.ok()) break;
    const absl::MutexLock lock(&mutex_);
    deleted_.remove_if([key](const auto& deleted) { return deleted.first == key; });
  }
  if (!status.ok()) {
    spdlog::warn("the files of a deleted map cannot be removed yet; removal is retried later: {}",
                 std::string(status.message()));
  }
}

absl::StatusOr<MapRecord> RocksStore::CreateMap(const MapRecord& record) {
  if (!IsValidId(record.name.tenant) || !IsValidId(record.name.map)) {
    return InvalidField(reason::kBadName, "name", "a map's name must consist of two valid ids");
  }
  if (absl::Status status = CheckDisk(); !status.ok()) return status;
  const absl::MutexLock catalog_lock(&catalog_mutex_);
  MapEntry entry;
  entry.record = record;
  entry.record.condition = absl::OkStatus();
  {
    const absl::MutexLock lock(&mutex_);
    if (names_.contains(record.name)) {
      return MakeError(absl::StatusCode::kAlreadyExists,
                       reason::kAlreadyExists,
                       absl::StrCat("map ", record.name.ToString(), " exists already"));
    }
    entry.record.key = next_key_;
    next_key_ = next_key_.Next();
  }
  // The folder is completed under a temporary name, so a crash leaves no incomplete map.
  const std::filesystem::path place = MapFolderOf(folder_, entry.record.key).path();
  const MapFolder unfinished(place.string() + kUnfinishedSuffix, entry.record.key);
  absl::Status status = unfinished.Create(entry.record);
  if (status.ok()) status = MapDatabase::Create(unfinished.path(), DatabaseDependencies());
  if (status.ok()) status = RenameDurably(unfinished.path(), place);
  if (!status.ok()) {
    unfinished.Remove().IgnoreError();
    return status;
  }
  {
    const absl::MutexLock lock(&mutex_);
    names_.emplace(record.name, entry.record.key);
    maps_.emplace(entry.record.key, entry);
  }
  if (status = WriteCatalog(); !status.ok()) return status;
  return entry.record;
}

absl::Status RocksStore::UpdateMap(const MapRecord& record) {
  const absl::MutexLock catalog_lock(&catalog_mutex_);
  {
    const absl::MutexLock lock(&mutex_);
    const auto entry = maps_.find(record.key);
    if (entry == maps_.end()) return UnknownMap(record.key);
    const MapRecord& known = entry->second.record;
    if (!known.condition.ok()) return known.condition;
    if (known.name != record.name || known.config != record.config) {
      return absl::FailedPreconditionError("the name and the config of a map never change");
    }
  }
  if (absl::Status status = MapFolderOf(folder_, record.key).WriteRecord(record); !status.ok())
    return status;
  const absl::MutexLock lock(&mutex_);
  const auto entry = maps_.find(record.key);
  if (entry != maps_.end()) entry->second.record = record;
  return absl::OkStatus();
}

absl::Status RocksStore::DeleteMap(MapKey map) {
  {
    const absl::MutexLock catalog_lock(&catalog_mutex_);
    const MapFolder folder = MapFolderOf(folder_, map);
    {
      const absl::MutexLock lock(&mutex_);
      if (!maps_.contains(map)) return UnknownMap(map);
    }
    absl::Status status = folder.MarkDeleted();
    if (ReasonOf(status) == reason::kDiskLow) {
      // The mark needs disk space: removing the log of the deleted map frees some.
      std::error_code ignored;
      std::filesystem::remove_all(folder.path() / "log", ignored);
      status = folder.MarkDeleted();
    }
    // A missing folder needs no mark.
    if (!status.ok() && !absl::IsNotFound(status)) return status;
    const absl::MutexLock lock(&mutex_);
    const auto entry = maps_.find(map);
    names_.erase(entry->second.record.name);
    deleted_.emplace_back(map, entry->second.closed);
    maps_.erase(entry);
  }
  RemoveDeleted();
  return absl::OkStatus();
}

absl::StatusOr<std::vector<MapRecord>> RocksStore::ListMaps() {
  std::vector<MapRecord> records;
  const absl::MutexLock lock(&mutex_);
  records.reserve(names_.size());
  for (const auto& [name, key] : names_) records.push_back(maps_.at(key).record);
  return records;
}

absl::StatusOr<std::shared_ptr<MapDatabase>> RocksStore::Find(MapKey map) const {
  const absl::MutexLock lock(&mutex_);
  const auto entry = maps_.find(map);
  if (entry == maps_.end()) return UnknownMap(map);
  if (!entry->second.record.condition.ok()) return entry->second.record.condition;
  if (entry->second.database == nullptr) return NotOpen(map);
  return entry->second.database;
}

absl::StatusOr<std::shared_ptr<MapDatabase>> RocksStore::OpenDatabase(const MapRecord& record) {
  std::shared_ptr<WriterMutex> opening;
  {
    const absl::MutexLock lock(&mutex_);
    const auto entry = maps_.find(record.key);
    if (entry == maps_.end()) return UnknownMap(record.key);
    opening = entry->second.opening;
  }
  const WriterMutex::Lock writer(opening.get());
  std::shared_ptr<absl::Notification> closing;
  {
    const absl::MutexLock lock(&mutex_);
    const auto entry = maps_.find(record.key);
    if (entry == maps_.end()) return UnknownMap(record.key);
    if (!entry->second.record.condition.ok()) return entry->second.record.condition;
    if (entry->second.database != nullptr && entry->second.database->health().ok()) {
      return entry->second.database;
    }
    entry->second.database.reset();
    closing = entry->second.closed;
  }
  // Only one database may be open per folder: wait until all users of the old one release it.
  if (closing != nullptr) closing->WaitForNotification();
  absl::StatusOr<std::unique_ptr<MapDatabase>> opened =
      MapDatabase::Open(MapFolderOf(folder_, record.key).path(), record, DatabaseDependencies());
  if (!opened.ok()) return opened.status();
  auto closed = std::make_shared<absl::Notification>();
  const std::shared_ptr<MapDatabase> database(opened->release(), [closed](MapDatabase* last) {
    delete last;
    closed->Notify();
  });
  const absl::MutexLock lock(&mutex_);
  const auto entry = maps_.find(record.key);
  if (entry == maps_.end()) return UnknownMap(record.key);
  entry->second.database = database;
  entry->second.closed = std::move(closed);
  return database;
}

absl::StatusOr<StoredState> RocksStore::LoadMap(const MapRecord& record) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = OpenDatabase(record);
  if (absl::IsNotFound(database.status())) return database.status();
  if (!database.ok()) return OfMap(record, database.status());
  absl::StatusOr<StoredState> state = (*database)->Load();
  if (!state.ok()) return OfMap(record, state.status());
  return state;
}

absl::Status RocksStore::Append(const LogAppend& append) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(append.map);
  return database.ok() ? (*database)->Append(append) : database.status();
}

absl::StatusOr<CommitMark> RocksStore::CommitRevision(MapKey map,
                                                      const MapDelta& delta,
                                                      const CommitDetails& details) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map);
  if (!database.ok()) return database.status();
  return (*database)->Commit(delta, details);
}

absl::Status RocksStore::ReadLog(MapKey map,
                                 MapSequence first,
                                 const std::function<absl::Status(LogEntry)>& visit) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map);
  return database.ok() ? (*database)->ReadLog(first, visit) : database.status();
}

absl::StatusOr<std::vector<FramePose>> RocksStore::ReadPoses(MapKey map,
                                                             MapSequence first,
                                                             MapSequence last,
                                                             std::size_t limit) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map);
  if (!database.ok()) return database.status();
  return (*database)->ReadPoses(first, last, limit);
}

absl::StatusOr<std::vector<StoredEvent>> RocksStore::ReadEvents(MapKey map,
                                                                EventNumber first,
                                                                std::size_t limit) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map);
  if (!database.ok()) return database.status();
  return (*database)->ReadEvents(first, limit);
}

absl::StatusOr<ChangeList> RocksStore::ReadChanges(MapKey map, CommitMark from, Revision to) {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map);
  if (!database.ok()) return database.status();
  return (*database)->ReadChanges(from, to);
}

absl::Status RocksStore::Trim(const MapRecord& map, const TrimBounds& bounds) {
  RemoveDeleted();
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map.key);
  return database.ok() ? (*database)->Trim(map, bounds) : database.status();
}

absl::Status RocksStore::health(MapKey map) const {
  const absl::StatusOr<std::shared_ptr<MapDatabase>> database = Find(map);
  return database.ok() ? (*database)->health() : database.status();
}

absl::Status RocksStore::CheckDisk() const {
  return CheckFreeSpace(platform_.free_disk_bytes(folder_), options_.min_free_disk_bytes);
}

bool RocksStore::IsWaitingForDisk() const { return gate_->waiting() > 0; }

void RocksStore::StopWaitingForDisk() { gate_->Stop(); }

StateDatabase& RocksStore::state_for_test(MapKey map) {
  return Find(map).value()->state_for_test();
}

absl::StatusOr<std::uint64_t> RocksStore::FreeDiskBytes(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) return SystemError(error.value(), "read the free space of", folder);
  return space.available;
}

MapDatabase::Dependencies RocksStore::DatabaseDependencies() const {
  return {&shared_, &options_, [this] { return platform_.free_disk_bytes(folder_); }};
}

}  // namespace steadymap
