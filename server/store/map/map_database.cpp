#include "server/store/map/map_database.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <rocksdb/snapshot.h>

#include "core/types/error.h"
#include "server/store/database/store_keys.h"
#include "server/store/database/store_records.h"
#include "server/store/disk/free_space.h"
#include "server/store/disk/posix_file.h"
#include "server/store/map/content_loader.h"
#include "server/store/map/map_history.h"
#include "server/store/map/state_reading.h"
#include "server/store/map/state_trim.h"
#include "server/store/model/history_hash.h"

namespace steadymap {
namespace {

// At its start, RocksDB writes a manifest, a log and the content of the old log.
constexpr std::uint64_t kOpenBytes = std::uint64_t{32} << 20;

// Interval at which the uptime of an idle map is stored, so that a restart loses little of it.
constexpr MapUptime kUptimeStep = std::chrono::minutes(10);

std::filesystem::path StateFolder(const std::filesystem::path& folder) { return folder / "state"; }

absl::Status MissingTailError(const char* what, std::uint64_t found, std::uint64_t known) {
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the map's ",
                                what,
                                " ends at ",
                                found,
                                ", but must reach ",
                                known,
                                ": files are missing, or older than the map"));
}

}  // namespace

MapDatabase::MapDatabase(const MapRecord& record, const Dependencies& dependencies)
    : record_(record), dependencies_(dependencies) {}

absl::Status MapDatabase::Create(const std::filesystem::path& folder,
                                 const Dependencies& dependencies) {
  absl::StatusOr<std::unique_ptr<StateDatabase>> state =
      StateDatabase::Open(StateFolder(folder), StateDatabase::Mode::kCreate, *dependencies.shared);
  if (!state.ok()) return state.status();
  rocksdb::WriteBatch batch;
  batch.Put((*state)->handle(Family::kMeta),
            HeadKey(),
            SealRecord({NameOf(Family::kMeta), HeadKey()}, storage::v1::Head()));
  return (*state)->Write(&batch);
}

absl::StatusOr<std::unique_ptr<MapDatabase>> MapDatabase::Open(const std::filesystem::path& folder,
                                                               const MapRecord& record,
                                                               const Dependencies& dependencies) {
  std::unique_ptr<MapDatabase> map(new MapDatabase(record, dependencies));
  if (absl::Status status = map->OpenState(folder); !status.ok()) return status;
  if (absl::Status status = map->OpenLog(folder); !status.ok()) return status;
  absl::StatusOr<std::shared_ptr<IntegrationNote>> note =
      dependencies.read_only ? IntegrationNote::Inspect(folder / "note")
                             : IntegrationNote::Open(folder / "note");
  // A note that cannot be created because the disk is full is replaced by one in memory until the
  // map is reopened.
  map->note_ = note.ok() ? *std::move(note) : IntegrationNote::InMemory();
  if (absl::Status status = map->CheckNote(); !status.ok()) return status;
  return map;
}

absl::Status MapDatabase::OpenState(const std::filesystem::path& folder) {
  // At most the reserve: a disk with enough free space for appends has enough to open a map.
  const std::uint64_t needed = std::min(kOpenBytes, dependencies_.options->min_free_disk_bytes);
  const bool has_room = !dependencies_.read_only && CheckFree(needed).ok();
  absl::StatusOr<std::unique_ptr<StateDatabase>> state = StateDatabase::Open(
      StateFolder(folder),
      has_room ? StateDatabase::Mode::kReadWrite : StateDatabase::Mode::kReadOnly,
      *dependencies_.shared);
  if (!state.ok()) return state.status();
  state_ = *std::move(state);
  Progress progress;
  if (absl::Status status = ReadHead(*state_, nullptr, &progress.head); !status.ok()) return status;
  if (absl::Status status = ReadAddedClasses(*state_, nullptr, &progress.added_classes);
      !status.ok()) {
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
      dependencies_.options->log_segment_bytes,
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

/// Returns `DataLoss` if the log or the database ends before the newest entry or revision recorded
/// by the note. Without this check, a missing newest file would not be detected.
absl::Status MapDatabase::CheckNote() const {
  const Progress found = progress();
  if (found.durable_head < note_->known_head()) {
    return MissingTailError("log", found.durable_head.value(), note_->known_head().value());
  }
  if (found.head.revision() < note_->known_revision().value()) {
    return MissingTailError("history", found.head.revision(), note_->known_revision().value());
  }
  return absl::OkStatus();
}

MapDatabase::Progress MapDatabase::progress() const {
  const absl::MutexLock lock(&mutex_);
  return progress_;
}

absl::Status MapDatabase::CheckFree(std::uint64_t needed) const {
  return CheckFreeSpace(dependencies_.free_disk_bytes(), needed);
}

absl::Status MapDatabase::Append(const LogAppend& append) {
  if (absl::Status status = health(); !status.ok()) return status;
  if (absl::Status status = CheckFree(dependencies_.options->min_free_disk_bytes); !status.ok()) {
    return status;
  }
  const WriterMutex::Lock writer(&append_mutex_);
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

absl::StatusOr<CommitMark> MapDatabase::Commit(const MapDelta& delta,
                                               const CommitDetails& details) {
  if (absl::Status status = state_->health(); !status.ok()) return status;
  const WriterMutex::Lock writer(&commit_mutex_);
  const Progress progress = this->progress();
  const storage::v1::Head& before = progress.head;
  if (delta.from.value() != before.revision() || delta.to < delta.from ||
      delta.to.value() > progress.durable_head.value()) {
    return absl::FailedPreconditionError(absl::StrCat("a commit from revision ",
                                                      delta.from.value(),
                                                      " to ",
                                                      delta.to.value(),
                                                      " does not fit map ",
                                                      record_.key.value(),
                                                      " at revision ",
                                                      before.revision(),
                                                      " with ",
                                                      progress.durable_head.value(),
                                                      " durable entries"));
  }
  if (delta.to == delta.from) return CommitMark{delta.from, before.history_hash()};
  // RocksDB writes this data a second time when it flushes its buffers.
  if (absl::Status status = CheckFree(dependencies_.options->write_buffer_bytes); !status.ok()) {
    return status;
  }
  storage::v1::Head head = before;
  head.set_revision(delta.to.value());
  head.set_last_capture_time_ns(delta.last_capture_time.nanoseconds());
  head.set_commits(before.commits() + 1);
  head.set_newest_object(delta.newest_object.value());
  head.set_events(before.events() + delta.events.size());
  head.set_uptime_ns(std::max<std::int64_t>(before.uptime_ns(), details.uptime.count()));
  RecordBatch records(*state_);
  records.PutContent(delta);
  records.PutEvents(delta.events, EventNumber{before.events() + 1});
  head.set_history_hash(ExtendHistory(before.history_hash(), delta.to, records.batch().Data()));
  records.PutPoses(details.poses);
  if (delta.added_classes.size() != progress.stored_classes) {
    records.PutAddedClasses(delta.added_classes);
  }
  records.PutChange(delta, before, head);
  PutProgress(progress, &head, &records);
  if (absl::Status status = state_->Write(&records.batch()); !status.ok()) return status;
  {
    const absl::MutexLock lock(&mutex_);
    progress_.stored_classes = delta.added_classes.size();
  }
  DropSavedSessions(head);
  note_->NoteRevision(delta.to);
  return CommitMark{delta.to, head.history_hash()};
}

/// Records that the database contains `head` and the sessions up to its group.
void MapDatabase::DropSavedSessions(const storage::v1::Head& head) {
  const absl::MutexLock lock(&mutex_);
  progress_.head = head;
  std::erase_if(progress_.unsaved_sessions, [&head](const auto& unsaved) {
    return unsaved.second.group <= head.saved_group();
  });
}

void MapDatabase::PutProgress(const Progress& progress,
                              storage::v1::Head* head,
                              RecordBatch* records) const {
  for (const auto& [name, unsaved] : progress.unsaved_sessions) {
    records->PutSession(unsaved.record);
  }
  head->set_durable_map_seq(progress.durable_head.value());
  head->set_saved_group(progress.group);
  records->PutHead(*head);
}

absl::StatusOr<StoredState> MapDatabase::Load() const {
  // The log is read first: it never ends before the state that is read after it.
  const Progress progress = this->progress();
  rocksdb::ManagedSnapshot snapshot(&state_->database());
  storage::v1::Head head;
  if (absl::Status status = ReadHead(*state_, snapshot.snapshot(), &head); !status.ok())
    return status;
  StoredState state;
  state.durable_head = std::max(progress.durable_head, MapSequence(head.revision()));
  state.durable_classes = record_.config.classes;
  state.durable_classes.insert(
      state.durable_classes.end(), progress.added_classes.begin(), progress.added_classes.end());
  state.commit = {Revision(head.revision()), head.history_hash()};
  state.uptime = MapUptime(std::max(head.uptime_ns(), progress.head.uptime_ns()));
  state.note = note_;
  state.snapshot = MapSnapshot({record_.config.voxel_size_m, record_.config.truncation_m});
  state.snapshot.revision = Revision{head.revision()};
  state.snapshot.last_capture_time = Timestamp::FromNanoseconds(head.last_capture_time_ns());
  state.snapshot.newest_object = ObjectId{head.newest_object()};
  state.snapshot.last_event = EventNumber{head.events()};
  absl::Status status =
      ReadAddedClasses(*state_, snapshot.snapshot(), &state.snapshot.added_classes);
  if (status.ok()) status = ReadSessions(*state_, snapshot.snapshot(), &state.sessions);
  if (!status.ok()) return status;
  for (const auto& [name, unsaved] : progress.unsaved_sessions) {
    std::erase_if(state.sessions,
                  [&name = name](const SessionRecord& known) { return known.name == name; });
    state.sessions.push_back(unsaved.record);
  }
  std::sort(state.sessions.begin(),
            state.sessions.end(),
            [](const SessionRecord& a, const SessionRecord& b) { return a.name < b.name; });
  status = LoadContent(*state_, snapshot.snapshot(), &state.snapshot);
  if (!status.ok()) return status;
  return state;
}

absl::Status MapDatabase::ReadLog(MapSequence first,
                                  const std::function<absl::Status(LogEntry)>& visit) const {
  // Retention may have dropped entries up to the revision; every later entry must exist.
  const MapSequence needed(progress().head.revision() + 1);
  return log_->Read(first, needed, visit);
}

absl::StatusOr<std::vector<FramePose>> MapDatabase::ReadPoses(MapSequence first,
                                                              MapSequence last,
                                                              std::size_t limit) const {
  return steadymap::ReadPoses(*state_, first, last, limit);
}

absl::StatusOr<std::vector<StoredEvent>> MapDatabase::ReadEvents(EventNumber first,
                                                                 std::size_t limit) const {
  return steadymap::ReadEvents(*state_, first, limit);
}

absl::StatusOr<ChangeList> MapDatabase::ReadChanges(CommitMark from, Revision to) const {
  return steadymap::ReadChanges(*state_, from, to);
}

absl::Status MapDatabase::Trim(const MapRecord& retention, const TrimBounds& bounds) {
  // On a full disk, log files whose content is already in the database can still be dropped.
  absl::Status status = state_->health();
  if (status.ok()) status = CheckFree(dependencies_.options->write_buffer_bytes);
  if (status.ok()) {
    const WriterMutex::Lock writer(&commit_mutex_);
    status = TrimState(bounds);
  }
  const bool keeps_log = !bounds.disk_is_low;
  const WriterMutex::Lock writer(&append_mutex_);
  const storage::v1::Head head = progress().head;
  const absl::Status dropped =
      log_->Drop({MapSequence(head.revision()), head.saved_group()},
                 keeps_log ? retention.frame_log_bytes : 0,
                 bounds.uptime,
                 keeps_log ? retention.frame_log_age : std::chrono::seconds(0));
  return status.ok() ? dropped : status;
}

absl::Status MapDatabase::TrimState(const TrimBounds& bounds) {
  RecordBatch records(*state_);
  rocksdb::WriteBatch& batch = records.batch();
  {
    const absl::MutexLock lock(&mutex_);
    std::erase_if(progress_.unsaved_sessions,
                  [&](const auto& unsaved) { return IsIdle(unsaved.second.record, bounds); });
  }
  absl::Status status = TrimSessions(*state_, bounds, &batch);
  if (!status.ok()) return status;
  // Read after the search for idle sessions: a session that is renewed meanwhile is stored again.
  const Progress progress = this->progress();
  storage::v1::Head head = progress.head;
  const StoreOptions& options = *dependencies_.options;
  status = TrimPoses(*state_, options, head, &batch);
  if (status.ok()) status = TrimChangeLists(*state_, options, head, bounds, &batch);
  if (status.ok()) status = TrimEvents(*state_, options, head, &batch);
  if (!status.ok()) return status;
  const bool knows_all = progress.group == head.saved_group() &&
                         progress.durable_head.value() == head.durable_map_seq();
  const bool is_young = bounds.uptime - MapUptime(head.uptime_ns()) < kUptimeStep;
  if (batch.Count() == 0 && knows_all && is_young) return absl::OkStatus();
  head.set_uptime_ns(std::max<std::int64_t>(head.uptime_ns(), bounds.uptime.count()));
  PutProgress(progress, &head, &records);
  status = state_->Write(&batch);
  if (status.ok()) DropSavedSessions(head);
  return status;
}

absl::Status MapDatabase::health() const {
  if (absl::Status status = state_->health(); !status.ok()) return status;
  return log_->health();
}

}  // namespace steadymap
