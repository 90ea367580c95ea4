#include "server/mapping/map_directory.h"

#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/synchronization/blocking_counter.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"

namespace steadymap {

absl::Status MapNotFound(const MapName& name, std::string_view field) {
  return MakeError(absl::StatusCode::kNotFound,
                   reason::kNotFound,
                   absl::StrCat("there is no map ", name.ToString()),
                   field);
}

MapDirectory::MapDirectory(MapRuntime::Dependencies dependencies)
    : dependencies_(std::move(dependencies)) {}

absl::Status MapDirectory::Load() {
  absl::StatusOr<std::vector<MapRecord>> records = dependencies_.store->ListMaps();
  if (!records.ok()) return records.status();
  for (const MapRecord& record : *records) {
    std::shared_ptr<MapRuntime> map = MapRuntime::Open(record, dependencies_);
    const absl::MutexLock lock(&mutex_);
    maps_.emplace(record.name, std::move(map));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<MapRuntime>> MapDirectory::Get(const MapName& name,
                                                              std::string_view field) const {
  const absl::MutexLock lock(&mutex_);
  const auto map = maps_.find(name);
  if (map == maps_.end()) return MapNotFound(name, field);
  return map->second;
}

absl::StatusOr<std::shared_ptr<MapRuntime>> MapDirectory::Find(const std::string& name,
                                                               std::string_view field) const {
  const absl::StatusOr<MapName> parsed = MapName::Parse(name);
  if (!parsed.ok()) {
    return InvalidField(ReasonOf(parsed.status()), field, std::string(parsed.status().message()));
  }
  return Get(*parsed, field);
}

std::vector<std::shared_ptr<MapRuntime>> MapDirectory::List(const std::string& tenant,
                                                            const std::string& after,
                                                            std::size_t limit) const {
  std::vector<std::shared_ptr<MapRuntime>> listed;
  const absl::MutexLock lock(&mutex_);
  for (auto map = maps_.upper_bound(MapName{tenant, after});
       map != maps_.end() && map->first.tenant == tenant && listed.size() < limit;
       ++map) {
    listed.push_back(map->second);
  }
  return listed;
}

std::vector<std::shared_ptr<MapRuntime>> MapDirectory::All() const {
  std::vector<std::shared_ptr<MapRuntime>> all;
  const absl::MutexLock lock(&mutex_);
  for (const auto& [name, map] : maps_) all.push_back(map);
  return all;
}

absl::StatusOr<std::shared_ptr<MapRuntime>> MapDirectory::Create(const MapRecord& record) {
  if (absl::Status status = dependencies_.memory->Check(); !status.ok()) return status;
  const absl::StatusOr<MapRecord> created = dependencies_.store->CreateMap(record);
  if (!created.ok()) return created.status();
  std::shared_ptr<MapRuntime> map = MapRuntime::Open(*created, dependencies_);
  const absl::MutexLock lock(&mutex_);
  maps_.insert_or_assign(record.name, map);
  return map;
}

absl::Status MapDirectory::Update(MapRuntime& map, const MapRecord& record) {
  if (absl::Status status = dependencies_.store->UpdateMap(record); !status.ok()) return status;
  map.SetRecord(record);
  return absl::OkStatus();
}

absl::Status MapDirectory::Delete(const std::shared_ptr<MapRuntime>& map,
                                  const std::function<void(const absl::Status&)>& end_streams) {
  if (absl::Status status = dependencies_.store->DeleteMap(map->key()); !status.ok()) return status;
  {
    const absl::MutexLock lock(&mutex_);
    const auto entry = maps_.find(map->name());
    if (entry != maps_.end() && entry->second == map) maps_.erase(entry);
  }
  const absl::Status gone = MapNotFound(map->name(), {});
  end_streams(gone);
  map->Close(gone, /*commit=*/false, [store = dependencies_.store] { store->Reclaim(); });
  spdlog::info("map {}: deleted", map->name().ToString());
  return absl::OkStatus();
}

void MapDirectory::Close(const absl::Status& status) {
  std::map<MapName, std::shared_ptr<MapRuntime>> closed;
  {
    const absl::MutexLock lock(&mutex_);
    closed.swap(maps_);
  }
  absl::BlockingCounter open(static_cast<int>(closed.size()));
  for (const auto& [name, map] : closed) {
    map->Close(status, /*commit=*/true, [&open] { open.DecrementCount(); });
  }
  open.Wait();
}

}  // namespace steadymap
