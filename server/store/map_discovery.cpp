#include "server/store/map_discovery.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <spdlog/spdlog.h>

#include "core/types/map_config.h"
#include "server/store/disk/posix_file.h"
#include "server/store/store_catalog.h"

namespace steadymap {
namespace {

/// Returns the name given to a map whose own name is lost.
MapName NameOfLost(MapKey key) { return {"lost", absl::StrCat("map-", key.value())}; }

absl::StatusOr<StoreCatalog> ReadCatalog(const MirroredFile& catalog_file) {
  const absl::StatusOr<std::string> bytes = catalog_file.Read();
  if (bytes.ok()) return StoreCatalog::Unpack(*bytes);
  if (!absl::IsNotFound(bytes.status())) {
    spdlog::error("{}; the list of maps is rebuilt from the map folders",
                  std::string(bytes.status().message()));
  }
  return StoreCatalog();
}

MapRecord LoadRecord(const MapFolder& folder, const StoreCatalog::Map& map) {
  absl::StatusOr<MapRecord> record = folder.ReadRecord();
  if (record.ok() && folder.IsCopy()) {
    spdlog::warn("map {}: its folder is a copy; the map gets a new incarnation",
                 record->name.ToString());
    record = folder.Adopt(*std::move(record));
  }
  MapRecord loaded;
  if (record.ok()) {
    loaded = *std::move(record);
  } else {
    loaded.condition = record.status();
  }
  loaded.key = map.key;
  loaded.name = map.name;
  for (const std::string& name : RemoveInvalidParameters(&loaded.config)) {
    spdlog::warn("map {}: parameter {} is not valid in this version; its default is used",
                 loaded.name.ToString(),
                 name);
  }
  return loaded;
}

/// Returns the key encoded in the name of a map's folder; none for any other folder.
std::optional<MapKey> KeyOfFolder(const std::filesystem::path& folder) {
  std::uint64_t number = 0;
  const std::string name = folder.filename().string();
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  const MapKey key(number);
  const bool is_number = error == std::errc() && end == name.data() + name.size();
  const std::filesystem::path data_folder = folder.parent_path().parent_path();
  if (!is_number || MapFolderOf(data_folder, key).path() != folder) return std::nullopt;
  return key;
}

bool IsNameTaken(const DiscoveredMaps& maps, const MapName& name) {
  return std::any_of(maps.records.begin(), maps.records.end(), [&name](const auto& known) {
    return known.second.name == name;
  });
}

void AddFolder(const std::filesystem::path& path, DiscoveredMaps* maps) {
  if (path.extension() == kUnfinishedSuffix &&
      KeyOfFolder(std::filesystem::path(path).replace_extension())) {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
    return;
  }
  const std::optional<MapKey> key = KeyOfFolder(path);
  if (!key) {
    spdlog::warn("{} is not the folder of a map; it is ignored", path.string());
    return;
  }
  const MapFolder folder(path, *key);
  maps->next_key = std::max(maps->next_key, key->Next());
  if (folder.IsDeleted()) {
    maps->records.erase(*key);
    maps->deleted.push_back(*key);
    return;
  }
  if (maps->records.contains(*key)) return;
  const absl::StatusOr<MapRecord> stored = folder.ReadRecord();
  MapRecord record = LoadRecord(folder, {*key, stored.ok() ? stored->name : NameOfLost(*key)});
  // Another map may have received the same name since.
  if (IsNameTaken(*maps, record.name)) record.name = NameOfLost(*key);
  maps->records.emplace(*key, std::move(record));
}

}  // namespace

MapFolder MapFolderOf(const std::filesystem::path& folder, MapKey key) {
  return {folder / kMapsFolderName / absl::StrFormat("%020d", key.value()), key};
}

absl::StatusOr<DiscoveredMaps> DiscoverMaps(const std::filesystem::path& folder,
                                            const MirroredFile& catalog_file) {
  const absl::StatusOr<StoreCatalog> catalog = ReadCatalog(catalog_file);
  if (!catalog.ok()) return catalog.status();
  DiscoveredMaps maps;
  maps.next_key = catalog->next_key;
  for (const StoreCatalog::Map& map : catalog->maps) {
    maps.records.emplace(map.key, LoadRecord(MapFolderOf(folder, map.key), map));
  }
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder / kMapsFolderName, error)) {
    AddFolder(entry.path(), &maps);
  }
  if (error) return SystemError(error.value(), "list", folder / kMapsFolderName);
  return maps;
}

}  // namespace steadymap
