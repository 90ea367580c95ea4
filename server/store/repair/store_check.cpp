#include "server/store/repair/store_check.h"

#include <algorithm>
#include <charconv>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "server/store/database/state_database.h"
#include "server/store/disk/folder_lock.h"
#include "server/store/disk/mirrored_file.h"
#include "server/store/log/log_segment.h"
#include "server/store/map/map_database.h"
#include "server/store/map/map_folder.h"
#include "server/store/store_catalog.h"

namespace steadymap {
namespace {

/// Parses `name` as a number; none if it is not a number as a whole.
std::optional<std::uint64_t> NumberOf(const std::string& name) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return number;
}

/// Returns the name of a map in the catalog.
MapName NameInCatalog(const StoreCatalog& catalog, MapKey key) {
  for (const StoreCatalog::Map& map : catalog.maps) {
    if (map.key == key) return map.name;
  }
  return {"lost", absl::StrCat("map-", key.value())};
}

/// Checks the files that belong to no map. Returns the catalog.
StoreCatalog CheckStoreFiles(const std::filesystem::path& data_dir,
                             std::vector<std::string>* problems) {
  StoreCatalog catalog;
  std::error_code error;
  // A store without any map so far has no catalog.
  if (std::filesystem::is_empty(data_dir / "maps", error)) return catalog;
  const absl::StatusOr<std::string> bytes = MirroredFile(data_dir / "catalog").Inspect(problems);
  if (!bytes.ok()) return catalog;
  absl::StatusOr<StoreCatalog> read = StoreCatalog::Unpack(*bytes);
  if (read.ok()) return *std::move(read);
  problems->emplace_back(read.status().message());
  return catalog;
}

/// Checks every log file, and that the files are consecutive.
void CheckLog(const std::filesystem::path& folder, MapKey map, std::vector<std::string>* problems) {
  const std::vector<std::filesystem::path> files = LogFiles(folder);
  std::optional<SegmentScan> before;
  for (std::size_t i = 0; i < files.size(); ++i) {
    absl::StatusOr<SegmentScan> scan = ScanSegment(files[i], map, i + 1 == files.size());
    if (!scan.ok()) {
      problems->emplace_back(scan.status().message());
      before.reset();
      continue;
    }
    const bool follows = !before || (scan->start.first_entry == before->last_entry.Next() &&
                                     scan->start.first_group == before->last_group + 1);
    if (!follows) {
      problems->push_back(absl::StrCat("log file ",
                                       files[i].string(),
                                       " begins with entry ",
                                       scan->start.first_entry.value(),
                                       ", but the file before it ends with entry ",
                                       before->last_entry.value()));
    }
    before = *std::move(scan);
  }
}

/// Loads the map as a server would.
absl::Status CheckLoading(const std::filesystem::path& folder, const MapRecord& record) {
  const StoreOptions options;
  const SharedResources shared(options);
  MapDatabase::Dependencies dependencies;
  dependencies.shared = &shared;
  dependencies.options = &options;
  dependencies.free_disk_bytes = [] { return std::uint64_t{0}; };
  dependencies.read_only = true;
  const absl::StatusOr<std::unique_ptr<MapDatabase>> map =
      MapDatabase::Open(folder, record, dependencies);
  if (!map.ok()) return map.status();
  const absl::StatusOr<StoredState> state = (*map)->Load();
  if (!state.ok()) return state.status();
  return (*map)->ReadLog(state->snapshot.integrated().Next(),
                         [](const LogEntry&) { return absl::OkStatus(); });
}

void CheckMap(MapCheckResult* map) {
  const absl::StatusOr<MapRecord> record =
      MapFolder(map->folder, map->key).InspectRecord(&map->problems);
  if (!record.ok()) map->problems.emplace_back(record.status().message());
  CheckLog(map->folder / "log", map->key, &map->problems);
  const absl::Status database = CheckDatabase(map->folder / "state");
  if (!database.ok()) map->problems.emplace_back(database.message());
  if (!record.ok() || !map->problems.empty()) return;
  const absl::Status loading = CheckLoading(map->folder, *record);
  if (!loading.ok()) map->problems.emplace_back(loading.message());
}

}  // namespace

bool StoreCheckResult::ok() const {
  return problems.empty() && std::all_of(maps.begin(), maps.end(), [](const MapCheckResult& map) {
           return map.problems.empty();
         });
}

std::vector<std::filesystem::path> LogFiles(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".log" && NumberOf(entry.path().stem())) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

absl::Status CheckDatabase(const std::filesystem::path& folder) {
  const SharedResources shared{StoreOptions()};
  const absl::StatusOr<std::unique_ptr<StateDatabase>> state =
      StateDatabase::Open(folder, StateDatabase::Mode::kReadOnly, shared);
  absl::Status status = state.ok() ? (*state)->Verify() : state.status();
  if (status.ok()) return status;
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("database ", folder.string(), ": ", status.message()));
}

absl::StatusOr<StoreCheckResult> FindMaps(const std::filesystem::path& data_dir) {
  StoreCheckResult findings;
  const StoreCatalog catalog = CheckStoreFiles(data_dir, &findings.problems);
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(data_dir / "maps", error)) {
    const std::optional<std::uint64_t> number = NumberOf(entry.path().filename());
    if (!number) continue;
    const MapKey key(*number);
    const MapFolder folder(entry.path(), key);
    if (folder.IsDeleted()) continue;
    std::vector<std::string> ignored;
    const absl::StatusOr<MapRecord> record = folder.InspectRecord(&ignored);
    findings.maps.push_back(
        {key, record.ok() ? record->name : NameInCatalog(catalog, key), entry.path(), {}});
  }
  if (error) {
    return absl::NotFoundError(
        absl::StrCat("cannot list ", (data_dir / "maps").string(), ": ", error.message()));
  }
  for (const StoreCatalog::Map& map : catalog.maps) {
    const bool is_there = std::any_of(
        findings.maps.begin(), findings.maps.end(), [&map](const MapCheckResult& found) {
          return found.key == map.key;
        });
    if (is_there) continue;
    findings.problems.push_back(
        absl::StrCat("map ", map.name.ToString(), ": its folder is missing"));
  }
  std::sort(findings.maps.begin(),
            findings.maps.end(),
            [](const MapCheckResult& a, const MapCheckResult& b) { return a.key < b.key; });
  return findings;
}

absl::StatusOr<StoreCheckResult> CheckStore(const std::filesystem::path& data_dir,
                                            const std::optional<MapName>& only) {
  std::error_code error;
  if (!std::filesystem::is_directory(data_dir / "maps", error)) {
    return absl::NotFoundError(absl::StrCat("there is no store in ", data_dir.string()));
  }
  const absl::StatusOr<FolderLock> lock = FolderLock::Take(data_dir);
  if (!lock.ok()) return lock.status();
  absl::StatusOr<StoreCheckResult> findings = FindMaps(data_dir);
  if (!findings.ok()) return findings.status();
  if (only) {
    findings->problems.clear();
    std::erase_if(findings->maps, [&only](const MapCheckResult& map) { return map.name != *only; });
    if (findings->maps.empty()) {
      return absl::NotFoundError(absl::StrCat("there is no map ", only->ToString()));
    }
  } else {
    MirroredFile(data_dir / "schema").Inspect(&findings->problems).IgnoreError();
  }
  for (MapCheckResult& map : findings->maps) CheckMap(&map);
  return findings;
}

}  // namespace steadymap
