// Which maps a store has: read at its start, and written when one comes or goes.

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "server/posix_file.h"
#include "server/rocks_store.h"

namespace steadymap {
namespace {

/// The name of a map that lost its own.
MapName NameOfLost(MapKey key) { return {"lost", absl::StrCat("map-", key.value())}; }

}  // namespace

/// Finds the maps: those of the catalog, and those whose folders are there though no catalog knows
/// of them, as when it was lost.
absl::Status RocksStore::LoadCatalog() {
  StoreCatalog catalog;
  const absl::StatusOr<std::string> bytes = catalog_file_.Read();
  if (bytes.ok()) {
    absl::StatusOr<StoreCatalog> read = StoreCatalog::Unpack(*bytes);
    if (!read.ok()) return read.status();
    catalog = *std::move(read);
  } else if (!absl::IsNotFound(bytes.status())) {
    spdlog::error("{}; the maps are found by their folders", std::string(bytes.status().message()));
  }
  for (const StoreCatalog::Map& map : catalog.maps) {
    MapEntry entry = LoadEntry(map);
    const absl::MutexLock lock(&mutex_);
    names_.emplace(entry.record.name, map.key);
    maps_.emplace(map.key, std::move(entry));
  }
  {
    const absl::MutexLock lock(&mutex_);
    next_key_ = std::max(next_key_, catalog.next_key);
  }
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / kMapsFolderName, error)) {
    AdoptFolder(entry.path());
  }
  return error ? SystemError(error.value(), "list", folder_ / kMapsFolderName) : absl::OkStatus();
}

RocksStore::MapEntry RocksStore::LoadEntry(const StoreCatalog::Map& map) {
  const MapFolder folder = FolderOf(map.key);
  MapEntry entry;
  absl::StatusOr<MapRecord> record = folder.ReadRecord();
  if (record.ok() && folder.IsCopy()) {
    spdlog::warn("map {}: its folder is a copy; it gets another incarnation",
                 record->name.ToString());
    record = folder.Adopt(*std::move(record));
  }
  if (record.ok()) {
    entry.record = *std::move(record);
  } else {
    entry.record.condition = record.status();
  }
  entry.record.key = map.key;
  entry.record.name = map.name;
  return entry;
}

void RocksStore::AdoptFolder(const std::filesystem::path& folder) {
  std::uint64_t number = 0;
  const std::string name = folder.filename().string();
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const MapKey key(number);
  if (std::string_view(end) == kUnfinishedSuffix) {
    // A map that a crash kept from coming to be.
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
    return;
  }
  if (error != std::errc() || end != name.data() + name.size() || FolderOf(key).path() != folder) {
    spdlog::warn("{} is no map's folder; it is left alone", folder.string());
    return;
  }
  const bool is_deleted = FolderOf(key).IsDeleted();
  const absl::MutexLock lock(&mutex_);
  next_key_ = std::max(next_key_, key.Next());
  const auto known = maps_.find(key);
  if (is_deleted) {
    if (known != maps_.end()) {
      names_.erase(known->second.record.name);
      maps_.erase(known);
    }
    deleted_.emplace_back(key, nullptr);
    return;
  }
  if (known != maps_.end()) return;
  const absl::StatusOr<MapRecord> record = FolderOf(key).ReadRecord();
  MapEntry entry = LoadEntry({key, record.ok() ? record->name : NameOfLost(key)});
  // Its name may have been given to another map since.
  if (names_.contains(entry.record.name)) entry.record.name = NameOfLost(key);
  names_.emplace(entry.record.name, key);
  maps_.emplace(key, std::move(entry));
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

/// Gives the space of deleted maps back, as far as nobody uses them any more.
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
  // The catalog first: a map that it names and that has no folder is a loss.
  absl::Status status = WriteCatalog();
  for (const MapKey key : unused) {
    if (status.ok()) status = FolderOf(key).Remove();
    if (!status.ok()) break;
    const absl::MutexLock lock(&mutex_);
    deleted_.remove_if([key](const auto& deleted) { return deleted.first == key; });
  }
  if (!status.ok()) {
    spdlog::warn("the space of a deleted map is not given back yet: {}",
                 std::string(status.message()));
  }
}

}  // namespace steadymap
