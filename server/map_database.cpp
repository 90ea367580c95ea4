#include "server/map_database.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "server/posix_file.h"
#include "server/store_keys.h"

namespace steadymap {
namespace {

// Starting RocksDB writes a manifest, a log and what the old log held.
constexpr std::uint64_t kOpenBytes = std::uint64_t{32} << 20;

std::filesystem::path StateFolder(const std::filesystem::path& folder) { return folder / "state"; }

absl::Status Lost(const char* what, std::uint64_t found, std::uint64_t known) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the map's ",
                                what,
                                " ends at ",
                                found,
                                ", but had come to ",
                                known,
                                ": files are missing, or older than the map"));
}

}  // namespace

MapDatabase::MapDatabase(const MapRecord& record, const Surroundings& surroundings)
    : record_(record), surroundings_(surroundings) {}

absl::Status MapDatabase::Create(const std::filesystem::path& folder,
                                 const Surroundings& surroundings) {
  absl::StatusOr<std::unique_ptr<StateDatabase>> state =
      StateDatabase::Open(StateFolder(folder), StateDatabase::Mode::kCreate, *surroundings.shared);
  if (!state.ok()) return state.status();
  rocksdb::WriteBatch batch;
  batch.Put((*state)->handle(Family::kMeta),
            HeadKey(),
            SealRecord({NameOf(Family::kMeta), HeadKey()}, storage::v1::Head()));
  return (*state)->Write(&batch);
}

absl::StatusOr<std::unique_ptr<MapDatabase>> MapDatabase::Open(const std::filesystem::path& folder,
                                                               const MapRecord& record,
                                                               const Surroundings& surroundings) {
  std::unique_ptr<MapDatabase> map(new MapDatabase(record, surroundings));
  if (absl::Status status = map->OpenState(folder); !status.ok()) return status;
  if (absl::Status status = map->OpenLog(folder); !status.ok()) return status;
  absl::StatusOr<std::shared_ptr<IntegrationNote>> note =
      surroundings.read_only ? IntegrationNote::Inspect(folder / "note")
                             : IntegrationNote::Open(folder / "note");
  // A note that cannot be made for want of space is not missed until there is some.
  map->note_ = note.ok() ? *std::move(note) : IntegrationNote::InMemory();
  if (absl::Status status = map->CheckNote(); !status.ok()) return status;
  return map;
}

absl::Status MapDatabase::OpenState(const std::filesystem::path& folder) {
  // Not more than the reserve: a disk with enough for appends has enough to be opened.
  const std::uint64_t needed = std::min(kOpenBytes, surroundings_.options->min_free_disk_bytes);
  const bool has_room = !surroundings_.read_only && CheckFree(needed).ok();
  absl::StatusOr<std::unique_ptr<StateDatabase>> state = StateDatabase::Open(
      StateFolder(folder),
      has_room ? StateDatabase::Mode::kReadWrite : StateDatabase::Mode::kReadOnly,
      *surroundings_.shared);
  if (!state.ok()) return state.status();
  state_ = *std::move(state);
  Progress progress;
  if (absl::Status status = LoadHead(nullptr, &progress.head); !status.ok()) return status;
  if (absl::Status status = LoadClasses(nullptr, &progress.added_classes); !status.ok()) {
    return status;
  }
  progress.stored_classes = progress.added_classes.size();
  const absl::MutexLock lock(&mutex_);
  progress_ = std::move(progress);
  return absl::OkStatus();
}

absl::Status MapDatabase::OpenLog(const std::filesystem::path& folder) {
  const storage::v1::Head head = progress().head;
  EntryLog::Found found;
  absl::StatusOr<std::unique_ptr<EntryLog>> log = EntryLog::Open(
      folder / "log",
      record_.key,
      {MapSequence(head.durable_map_seq()), Revision(head.revision()), head.saved_group()},
      surroundings_.options->log_segment_bytes,
      /*read_only=*/!state_->health().ok(),
      &found);
  if (!log.ok()) return log.status();
  log_ = *std::move(log);
  const absl::MutexLock lock(&mutex_);
  progress_.durable_head = log_->head();
  progress_.group = log_->group();
  progress_.head.set_uptime_ns(
      std::max<std::int64_t>(progress_.head.uptime_ns(), found.uptime.count()));
  for (auto& [name, session] : found.sessions) {
    progress_.unsaved_sessions[name] = {std::move(session), progress_.group};
  }
  for (const LogEntry& entry : found.classes) {
    progress_.added_classes.insert(
        progress_.added_classes.end(), entry.classes.begin(), entry.classes.end());
  }
  return absl::OkStatus();
}

/// Whether everything is there that was there once: a missing newest file would go unnoticed else.
absl::Status MapDatabase::CheckNote() const {
  const Progress found = progress();
  if (found.durable_head < note_->known_head()) {
    return Lost("log", found.durable_head.value(), note_->known_head().value());
  }
  if (found.head.revision() < note_->known_revision().value()) {
    return Lost("history", found.head.revision(), note_->known_revision().value());
  }
  return absl::OkStatus();
}

MapDatabase::Progress MapDatabase::progress() const {
  const absl::MutexLock lock(&mutex_);
  return progress_;
}

absl::Status MapDatabase::CheckFree(std::uint64_t needed) const {
  const absl::StatusOr<std::uint64_t> free_bytes = surroundings_.free_disk_bytes();
  if (!free_bytes.ok()) return free_bytes.status();
  if (*free_bytes >= needed) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kDiskLow,
                   absl::StrCat("the disk of the data folder has ",
                                *free_bytes,
                                " bytes left, fewer than the ",
                                needed,
                                " that are kept free"));
}

absl::Status MapDatabase::Append(const LogAppend& append) {
  if (absl::Status status = health(); !status.ok()) return status;
  if (absl::Status status = CheckFree(surroundings_.options->min_free_disk_bytes); !status.ok()) {
    return status;
  }
  const WriteTurn::Held turn(&append_turn_);
  if (absl::Status status = log_->Append(append); !status.ok()) return status;
  const absl::MutexLock lock(&mutex_);
  progress_.durable_head = log_->head();
  progress_.group = log_->group();
  for (const SessionRecord& session : append.sessions) {
    progress_.unsaved_sessions[session.name] = {session, progress_.group};
  }
  for (const LogEntry& entry : append.entries) {
    progress_.added_classes.insert(
        progress_.added_classes.end(), entry.classes.begin(), entry.classes.end());
  }
  note_->NoteHead(progress_.durable_head);
  return absl::OkStatus();
}

absl::Status MapDatabase::ReadLog(MapSequence first,
                                  const std::function<absl::Status(LogEntry)>& visit) const {
  // Up to the revision retention may have dropped entries; behind it none may be missing.
  const MapSequence needed(progress().head.revision() + 1);
  return log_->Read(first, needed, visit);
}

absl::Status MapDatabase::health() const {
  if (absl::Status status = state_->health(); !status.ok()) return status;
  return log_->health();
}

}  // namespace steadymap
