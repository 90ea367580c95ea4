#include "server/store/repair/map_salvage.h"

#include <algorithm>
#include <memory>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "server/store/database/state_database.h"
#include "server/store/database/store_keys.h"
#include "server/store/database/store_records.h"
#include "server/store/disk/folder_lock.h"
#include "server/store/disk/posix_file.h"
#include "server/store/map/map_folder.h"
#include "server/store/repair/log_salvage.h"
#include "server/store/repair/store_check.h"

#include "steadymap/storage/v1/records.pb.h"

namespace steadymap {
namespace {

absl::Status CopyFolder(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::remove_all(to, error);
  std::filesystem::copy(from, to, std::filesystem::copy_options::recursive, error);
  return error ? SystemError(error.value(), "copy", from) : absl::OkStatus();
}

absl::Status WriteHead(StateDatabase* state, const storage::v1::Head& head) {
  rocksdb::WriteBatch batch;
  batch.Put(state->handle(Family::kMeta),
            HeadKey(),
            SealRecord({NameOf(Family::kMeta), HeadKey()}, head));
  return state->Write(&batch);
}

absl::StatusOr<storage::v1::Head> ReadHead(const StateDatabase& state) {
  const absl::StatusOr<std::string> value = state.Read(Family::kMeta, HeadKey());
  if (!value.ok()) return value.status();
  storage::v1::Head head;
  const absl::Status status = UnsealRecord({NameOf(Family::kMeta), HeadKey()}, *value, &head);
  if (!status.ok()) return status;
  return head;
}

/// Builds the salvaged folder of one map, step by step.
class MapSalvage {
 public:
  MapSalvage(MapCheckResult map, std::filesystem::path to, SalvageReport* report)
      : map_(std::move(map)), to_(std::move(to)), shared_(StoreOptions()), report_(report) {}

  absl::Status Run(std::optional<MapSequence> skip_entry) {
    std::vector<std::string> problems;
    absl::StatusOr<MapRecord> record = MapFolder(map_.folder, map_.key).InspectRecord(&problems);
    if (!record.ok()) return record.status();
    const MapFolder made(to_, map_.key);
    if (absl::Status status = made.Create(*record); !status.ok()) return status;
    absl::StatusOr<SalvagedLog> log =
        SalvageLog(map_.folder / "log", to_ / "log", map_.key, skip_entry);
    if (!log.ok()) return log.status();
    log_ = *std::move(log);
    for (const std::string& remark : log_.remarks) Remark(remark);
    const absl::StatusOr<bool> kept = MakeState();
    if (!kept.ok()) return kept.status();
    ReportLosses();
    return *kept ? absl::OkStatus() : made.Adopt(*std::move(record)).status();
  }

 private:
  void Remark(std::string remark) { report_->remarks.push_back(std::move(remark)); }

  std::filesystem::path OldState() const { return map_.folder / "state"; }

  std::filesystem::path NewState() const { return to_ / "state"; }

  /// Creates the new database. Returns true if the old database was kept.
  absl::StatusOr<bool> MakeState() {
    const absl::Status damage = CheckDatabase(OldState());
    if (damage.ok()) {
      if (absl::Status status = CopyFolder(OldState(), NewState()); !status.ok()) return status;
      if (absl::Status status = LimitHead(); !status.ok()) return status;
      return true;
    }
    Remark(std::string(damage.message()));
    const bool has_all = log_.first_entry == MapSequence(1);
    if (!has_all && RepairState()) return false;
    const absl::Status status = MakeEmptyState();
    if (!status.ok()) return status;
    Remark(has_all ? "the database is rebuilt from the log, which contains every entry: the server "
                     "integrates the log at the next start, with an identical map as the result"
                   : absl::StrCat(
                         "no part of the database can be used: the map is rebuilt starting with "
                         "entry ",
                         log_.first_entry.value(),
                         ", the oldest in the log"));
    return false;
  }

  /// Repairs the database from its readable parts. Returns true if the result is usable.
  bool RepairState() {
    absl::Status status = CopyFolder(OldState(), NewState());
    if (status.ok()) status = StateDatabase::Repair(NewState(), shared_);
    if (status.ok()) status = CheckDatabase(NewState());
    if (status.ok()) status = LimitHead();
    if (!status.ok()) return false;
    Remark(absl::StrCat("the database was repaired and is at revision ",
                        revision_,
                        ": parts of the map may be missing or from an older revision"));
    return true;
  }

  /// Limits the log's end recorded in the database to the end of the salvaged log.
  absl::Status LimitHead() {
    absl::StatusOr<std::unique_ptr<StateDatabase>> state =
        StateDatabase::Open(NewState(), StateDatabase::Mode::kReadWrite, shared_);
    if (!state.ok()) return state.status();
    absl::StatusOr<storage::v1::Head> head = ReadHead(**state);
    if (!head.ok()) return head.status();
    revision_ = head->revision();
    const std::uint64_t end = std::max(log_.head.value(), revision_);
    known_head_ = std::max(known_head_, head->durable_map_seq());
    if (head->durable_map_seq() <= end) return absl::OkStatus();
    head->set_durable_map_seq(end);
    return WriteHead(state->get(), *head);
  }

  absl::Status MakeEmptyState() {
    std::error_code error;
    std::filesystem::remove_all(NewState(), error);
    absl::StatusOr<std::unique_ptr<StateDatabase>> state =
        StateDatabase::Open(NewState(), StateDatabase::Mode::kCreate, shared_);
    if (!state.ok()) return state.status();
    storage::v1::Head head;
    if (log_.first_group != 0) {
      head.set_revision(log_.first_entry.value() - 1);
      head.set_durable_map_seq(head.revision());
      head.set_saved_group(log_.first_group - 1);
    }
    revision_ = head.revision();
    return WriteHead(state->get(), head);
  }

  void ReportLosses() {
    const absl::StatusOr<std::shared_ptr<IntegrationNote>> note =
        IntegrationNote::Inspect(map_.folder / "note");
    if (note.ok()) known_head_ = std::max(known_head_, (*note)->known_head().value());
    for (const MapSequence lost : log_.lost) {
      Remark(absl::StrCat("entry ",
                          lost.value(),
                          " of the log is lost",
                          lost.value() <= revision_ ? "; the map already contains it" : ""));
    }
    const std::uint64_t end = std::max(log_.head.value(), revision_);
    if (known_head_ > end) {
      Remark(absl::StrCat("the entries ", end + 1, " to ", known_head_, " of the log are lost"));
    }
  }

  const MapCheckResult map_;
  const std::filesystem::path to_;
  const SharedResources shared_;
  SalvageReport* const report_;
  SalvagedLog log_;
  std::uint64_t revision_ = 0;
  std::uint64_t known_head_ = 0;
};

/// Returns a path for the old files that does not exist yet.
std::filesystem::path PlaceForOldFiles(const std::filesystem::path& data_dir, MapKey key) {
  for (int number = 1;; ++number) {
    std::filesystem::path place = data_dir / "salvaged" / absl::StrCat(key.value(), "-", number);
    std::error_code error;
    if (!std::filesystem::exists(place, error)) return place;
  }
}

}  // namespace

absl::StatusOr<SalvageReport> SalvageMap(const SalvageOptions& options) {
  std::error_code error;
  if (!std::filesystem::is_directory(options.data_dir / "maps", error)) {
    return absl::NotFoundError(absl::StrCat("there is no store in ", options.data_dir.string()));
  }
  const absl::StatusOr<FolderLock> lock = FolderLock::Take(options.data_dir);
  if (!lock.ok()) return lock.status();
  const absl::StatusOr<StoreCheckResult> maps = FindMaps(options.data_dir);
  if (!maps.ok()) return maps.status();
  const auto map = std::find_if(maps->maps.begin(), maps->maps.end(), [&](const MapCheckResult& m) {
    return m.name == options.map;
  });
  if (map == maps->maps.end()) {
    return absl::NotFoundError(absl::StrCat("there is no map ", options.map.ToString()));
  }
  SalvageReport report;
  // The next start of the server removes an incomplete folder of this name.
  const bool in_place = options.output.empty();
  const std::filesystem::path made =
      in_place ? std::filesystem::path(map->folder.string() + ".new") : options.output;
  if (in_place) std::filesystem::remove_all(made, error);
  if (std::filesystem::exists(made, error)) {
    return absl::FailedPreconditionError(absl::StrCat(made.string(), " already exists"));
  }
  MapSalvage salvage(*map, made, &report);
  if (absl::Status status = salvage.Run(options.skip_entry); !status.ok()) return status;
  report.repaired = in_place ? map->folder : made;
  report.old_files = map->folder;
  if (!in_place) return report;
  report.old_files = PlaceForOldFiles(options.data_dir, map->key);
  absl::Status status = MakeFolder(report.old_files.parent_path());
  if (status.ok()) status = RenameDurably(map->folder, report.old_files);
  if (status.ok()) status = RenameDurably(made, map->folder);
  if (!status.ok()) return status;
  return report;
}

}  // namespace steadymap
