#include "server/store.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "server/store_records.h"

namespace steadymap {
namespace {

constexpr MapKey kCreationTurn{0};

void PutRecord(StoreDatabase* database, const MapRecord& record, rocksdb::WriteBatch* batch) {
  const std::string key = MapRecordKey(record.key);
  batch->Put(database->handle(Family::kMeta),
             key,
             SealRecord({NameOf(Family::kMeta), key}, ToProto(record)));
}

void PutKey(StoreDatabase* database,
            const std::string& key,
            MapKey value,
            rocksdb::WriteBatch* batch) {
  storage::v1::KeyRecord record;
  record.set_key(value.value());
  batch->Put(
      database->handle(Family::kMeta), key, SealRecord({NameOf(Family::kMeta), key}, record));
}

absl::Status UnknownMap(MapKey map) {
  return MakeError(absl::StatusCode::kNotFound,
                   reason::kNotFound,
                   absl::StrCat("the store has no map with key ", map.value()));
}

// A record or head that was never written is an empty one; anything else wrong with it is damage.
template <typename Proto>
absl::Status ReadOptional(const StoreDatabase& database,
                          const std::string& key,
                          const rocksdb::Snapshot* snapshot,
                          Proto* record) {
  const absl::StatusOr<std::string> value = database.Read(Family::kMeta, key, snapshot);
  if (absl::IsNotFound(value.status())) return absl::OkStatus();
  if (!value.ok()) return value.status();
  return UnsealRecord({NameOf(Family::kMeta), key}, *value, record);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Store>> Store::Open(const std::filesystem::path& folder,
                                                   const StoreOptions& options) {
  absl::StatusOr<std::unique_ptr<RocksStore>> store = RocksStore::Open(folder, options, nullptr);
  if (!store.ok()) return store.status();
  return std::unique_ptr<Store>(*std::move(store));
}

absl::StatusOr<std::unique_ptr<RocksStore>> RocksStore::Open(const std::filesystem::path& folder,
                                                             const StoreOptions& options,
                                                             rocksdb::Env* environment) {
  absl::StatusOr<std::unique_ptr<StoreDatabase>> database =
      StoreDatabase::Open(folder, options, environment);
  if (!database.ok()) return database.status();
  std::unique_ptr<RocksStore> store(new RocksStore(*std::move(database), options));
  if (absl::Status status = store->LoadEntries(); !status.ok()) return status;
  return store;
}

RocksStore::RocksStore(std::unique_ptr<StoreDatabase> database, const StoreOptions& options)
    : database_(std::move(database)), options_(options) {}

absl::Status RocksStore::LoadEntries() {
  absl::StatusOr<std::map<MapKey, MapName>> names = LoadNameIndex();
  if (!names.ok()) return names.status();
  storage::v1::KeyRecord next;
  if (absl::Status status = ReadOptional(*database_, NextMapKeyKey(), nullptr, &next);
      !status.ok()) {
    return status;
  }
  const absl::MutexLock lock(&mutex_);
  next_key_ = MapKey{std::max<std::uint64_t>(next.key(), 1)};
  for (const auto& [key, name] : *names) {
    absl::StatusOr<MapEntry> entry = LoadEntry(key, nullptr);
    if (absl::IsFailedPrecondition(entry.status())) return entry.status();
    if (!entry.ok()) {
      MapEntry damaged;
      damaged.record.key = key;
      damaged.record.condition = entry.status();
      entry = std::move(damaged);
    }
    entry->record.name = name;
    entries_.emplace(key, *std::move(entry));
    names_.emplace(name, key);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::map<MapKey, MapName>> RocksStore::LoadNameIndex() const {
  std::map<MapKey, MapName> names;
  const std::string prefix = NameIndexPrefix();
  const std::unique_ptr<rocksdb::Iterator> scan = database_->Scan(Family::kMeta, nullptr);
  for (scan->Seek(prefix); scan->Valid() && scan->key().starts_with(prefix); scan->Next()) {
    const std::string key = scan->key().ToString();
    const std::optional<MapName> name = NameOfIndexKey(key);
    storage::v1::KeyRecord record;
    const ValuePlace place{NameOf(Family::kMeta), key};
    if (absl::Status status = UnsealRecord(place, scan->value().ToStringView(), &record);
        !status.ok()) {
      return status;
    }
    if (!name) return DamagedValue(place, "is filed under no map's name");
    names.emplace(MapKey{record.key()}, *name);
  }
  if (!scan->status().ok()) return FromRocksdb(scan->status(), "reading the list of maps");
  return names;
}

absl::StatusOr<RocksStore::MapEntry> RocksStore::LoadEntry(
    MapKey key, const rocksdb::Snapshot* snapshot) const {
  storage::v1::MapRecord proto;
  const std::string record_key = MapRecordKey(key);
  const absl::StatusOr<std::string> value = database_->Read(Family::kMeta, record_key, snapshot);
  if (!value.ok()) return value.status();
  const ValuePlace place{NameOf(Family::kMeta), record_key};
  if (absl::Status status = UnsealRecord(place, *value, &proto); !status.ok()) return status;
  absl::StatusOr<MapRecord> record = FromProto(proto);
  if (!record.ok()) return record.status();
  MapEntry entry{*std::move(record), {}, {}};
  if (absl::Status status = ReadOptional(*database_, LogHeadKey(key), snapshot, &entry.log_head);
      !status.ok()) {
    return status;
  }
  if (absl::Status status =
          ReadOptional(*database_, RevisionHeadKey(key), snapshot, &entry.revision_head);
      !status.ok()) {
    return status;
  }
  return entry;
}

absl::StatusOr<RocksStore::MapEntry> RocksStore::Find(MapKey map) const {
  const absl::MutexLock lock(&mutex_);
  const auto entry = entries_.find(map);
  if (entry == entries_.end()) return UnknownMap(map);
  if (!entry->second.record.condition.ok()) return entry->second.record.condition;
  return entry->second;
}

absl::Status RocksStore::CheckDisk() const {
  const absl::StatusOr<std::uint64_t> free_bytes = database_->FreeDiskBytes();
  if (!free_bytes.ok()) return free_bytes.status();
  if (*free_bytes >= options_.min_free_disk_bytes) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kDiskLow,
                   absl::StrCat("the disk of the data folder has ",
                                *free_bytes,
                                " bytes left, fewer than the ",
                                options_.min_free_disk_bytes,
                                " that are kept free"));
}

absl::StatusOr<MapRecord> RocksStore::CreateMap(const MapRecord& record) {
  if (!IsValidId(record.name.tenant) || !IsValidId(record.name.map)) {
    return InvalidField(reason::kBadName, "name", "a map's name must be made of two valid ids");
  }
  if (absl::Status status = CheckDisk(); !status.ok()) return status;
  const WriteTurns::Turn turn(&append_turns_, {kCreationTurn});
  MapEntry entry{record, {}, {}};
  entry.record.condition = absl::OkStatus();
  {
    const absl::MutexLock lock(&mutex_);
    if (names_.contains(record.name)) {
      return MakeError(absl::StatusCode::kAlreadyExists,
                       reason::kAlreadyExists,
                       absl::StrCat("map ", record.name.ToString(), " exists already"));
    }
    entry.record.key = next_key_;
  }
  rocksdb::WriteBatch batch;
  PutRecord(database_.get(), entry.record, &batch);
  PutKey(database_.get(), NameIndexKey(record.name), entry.record.key, &batch);
  PutKey(database_.get(), NextMapKeyKey(), entry.record.key.Next(), &batch);
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  const absl::MutexLock lock(&mutex_);
  next_key_ = entry.record.key.Next();
  names_.emplace(record.name, entry.record.key);
  return entries_.emplace(entry.record.key, std::move(entry)).first->second.record;
}

absl::Status RocksStore::UpdateMap(const MapRecord& record) {
  const WriteTurns::Turn turn(&append_turns_, {record.key});
  const absl::StatusOr<MapEntry> entry = Find(record.key);
  if (!entry.ok()) return entry.status();
  if (entry->record.name != record.name || entry->record.config != record.config) {
    return absl::FailedPreconditionError("the name and the config of a map never change");
  }
  rocksdb::WriteBatch batch;
  PutRecord(database_.get(), record, &batch);
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  const absl::MutexLock lock(&mutex_);
  entries_.at(record.key).record = record;
  return absl::OkStatus();
}

absl::Status RocksStore::DeleteMap(MapKey map) {
  const WriteTurns::Turn append_turn(&append_turns_, {map});
  const WriteTurns::Turn commit_turn(&commit_turns_, {map});
  MapName name;
  {
    const absl::MutexLock lock(&mutex_);
    const auto entry = entries_.find(map);
    if (entry == entries_.end()) return UnknownMap(map);
    name = entry->second.record.name;
  }
  rocksdb::WriteBatch batch;
  const KeyRange range = MapRange(map);
  for (const Family family : kMapFamilies) {
    batch.DeleteRange(database_->handle(family), range.begin, range.end);
  }
  for (const std::string& key :
       {MapRecordKey(map), LogHeadKey(map), RevisionHeadKey(map), NameIndexKey(name)}) {
    batch.Delete(database_->handle(Family::kMeta), key);
  }
  if (absl::Status status = database_->Write(&batch); !status.ok()) return status;
  {
    const absl::MutexLock lock(&mutex_);
    names_.erase(name);
    entries_.erase(map);
  }
  for (const Family family : kMapFamilies) database_->Reclaim(family, range.begin, range.end);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<MapRecord>> RocksStore::ListMaps() {
  std::vector<MapRecord> records;
  const absl::MutexLock lock(&mutex_);
  records.reserve(names_.size());
  for (const auto& [name, key] : names_) records.push_back(entries_.at(key).record);
  return records;
}

absl::Status RocksStore::health() const { return database_->health(); }

}  // namespace steadymap
