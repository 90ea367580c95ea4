#include "server/mapping/map_runtime.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

// In-flight frames of 64 streams with 64 frames each; the log accepts them within a few
// milliseconds.
constexpr std::size_t kMaxQueuedFrames = 4096;

// Limits of one append: large enough that one disk sync covers many entries, small enough to bound
// the memory of a group.
constexpr std::size_t kMaxGroupFrames = 64;
constexpr std::size_t kMaxGroupBytes = std::size_t{8} << 20;

// Delays before a map is reopened after a failed write.
constexpr std::chrono::milliseconds kFirstRetry{500};
constexpr std::chrono::milliseconds kLongestRetry{10'000};

// Interval between checks of a full disk.
constexpr std::chrono::milliseconds kDiskRetry{1000};

/// The sender of an end of session that no client waits for.
class NoObserver final : public UploadObserver {
 public:
  bool IsAbandoned() const override { return false; }

  void OnReceived(ClientSequence /*through*/, std::vector<RefusedFrame> /*refused*/) override {}

  void OnDurable(const BatchProgress& /*progress*/) override {}

  void OnIntegrated(const BatchProgress& /*progress*/) override {}

  void OnFailed(const absl::Status& /*status*/) override {}
};

/// Returns the commit options of a map: those of the server, with the map's own settings applied.
CommitOptions CommitOf(const MapRecord& record, const CommitOptions& server) {
  CommitOptions commit = server;
  if (record.max_commit_delay.count() > 0) commit.max_delay = record.max_commit_delay;
  return commit;
}

absl::Status Opening(const MapName& name) {
  return WithRetryDelay(
      MakeError(absl::StatusCode::kUnavailable,
                reason::kMapOpening,
                absl::StrCat("map ", name.ToString(), " is still being read from disk")),
      500);
}

/// True if the error is temporary, so that reopening the map can succeed without an operator.
bool IsTemporary(const absl::Status& status) {
  return ReasonOf(status) == reason::kStoreReadOnly || ReasonOf(status) == reason::kDiskLow;
}

}  // namespace

std::shared_ptr<MapRuntime> MapRuntime::Open(const MapRecord& record,
                                             const Dependencies& dependencies) {
  auto map = std::make_shared<MapRuntime>(record, dependencies);
  // The strands own the map until they are stopped.
  map->append_strand_ = Strand::Make(dependencies.log_pool, [map] { return map->AppendStep(); });
  map->map_strand_ = Strand::Make(dependencies.map_pool, [map] { return map->MapStep(); });
  if (record.condition.ok()) {
    map->map_strand_->Wake();
  } else {
    map->Fail(record.condition);
  }
  return map;
}

MapRuntime::MapRuntime(const MapRecord& record, const Dependencies& dependencies)
    : key_(record.key),
      name_(record.name),
      dependencies_(dependencies),
      budget_account_(dependencies.budget->OpenAccount(dependencies.queue_bytes)),
      read_account_(dependencies.read_budget->OpenAccount(dependencies.queue_bytes / 2)),
      capture_clocks_(record.name.ToString()),
      class_log_(record.config),
      queue_(kMaxQueuedFrames),
      integrator_(dependencies.store,
                  &clock_,
                  CommitOf(record, dependencies.commit),
                  [this](PublishedRevision published) { Publish(std::move(published)); }),
      record_(record),
      health_{Condition::kOpening, Opening(record.name)} {
  // The queue is closed until the map is open, so that it refuses batches with the reason.
  queue_.Close(health_.reason);
}

MapRecord MapRuntime::record() const {
  const absl::MutexLock lock(&mutex_);
  return record_;
}

void MapRuntime::SetRecord(const MapRecord& record) {
  integrator_.SetMaxDelay(CommitOf(record, dependencies_.commit).max_delay);
  const absl::MutexLock lock(&mutex_);
  record_ = record;
}

MapRuntime::Health MapRuntime::health() const {
  const absl::MutexLock lock(&mutex_);
  return health_;
}

void MapRuntime::WhenOpened(std::function<void()> callback) {
  {
    const absl::MutexLock lock(&mutex_);
    if (health_.condition == Condition::kOpening) {
      when_opened_.push_back(std::move(callback));
      return;
    }
  }
  callback();
}

absl::Status MapRuntime::CheckReads() const {
  const absl::MutexLock lock(&mutex_);
  switch (health_.condition) {
    case Condition::kReady:
    case Condition::kReadOnly:
    case Condition::kQuarantined:
      return absl::OkStatus();
    case Condition::kOpening:
    case Condition::kDamaged:
    case Condition::kDeleted:
      return health_.reason;
  }
  return health_.reason;
}

absl::Status MapRuntime::CheckUploads() const {
  absl::Status memory = dependencies_.memory->Check();
  const absl::MutexLock lock(&mutex_);
  if (health_.condition != Condition::kReady) return health_.reason;
  if (!memory.ok()) return memory;
  const std::size_t memory_bytes = published_.counts.memory_bytes;
  if (record_.byte_budget == 0 || memory_bytes <= record_.byte_budget) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kMapBytes,
                   absl::StrCat("the map uses ",
                                memory_bytes,
                                " bytes of memory, more than its byte_budget of ",
                                record_.byte_budget));
}

std::shared_ptr<const MapSnapshot> MapRuntime::snapshot() const {
  const absl::MutexLock lock(&mutex_);
  return published_.snapshot;
}

PublishedRevision MapRuntime::published() const {
  const absl::MutexLock lock(&mutex_);
  return published_;
}

absl::Status MapRuntime::Enqueue(PendingBatch batch) {
  absl::Status status = queue_.Push(std::move(batch));
  if (status.ok()) append_strand_->Wake();
  return status;
}

void MapRuntime::EndSilentSessions(std::chrono::seconds max_silence) {
  if (condition() != Condition::kReady) return;
  const std::shared_ptr<const MapSnapshot> map = snapshot();
  for (const auto& [sensor, robot] : map->robots) {
    if (!robot.session_start) continue;
    const std::optional<SessionRecord> session = sessions_.NewestOf(sensor);
    if (!session || session->is_over) continue;
    if (clock_.Now() - session->last_active <= max_silence) continue;
    PendingBatch end;
    end.session = session->name;
    end.ends_session = true;
    end.observer = std::make_shared<NoObserver>();
    // A full queue has frames, and the next round comes soon.
    if (Enqueue(std::move(end)).ok()) {
      spdlog::info("map {} sensor {}: the session ends {} s after its last frame",
                   name_.ToString(),
                   sensor.ToString(),
                   max_silence.count());
    }
  }
}

void MapRuntime::AddClasses(std::vector<SemanticClass> classes,
                            const std::function<void(absl::Status)>& done) {
  absl::Status status = CheckUploads();
  if (status.ok()) status = class_log_.Queue({std::move(classes), done});
  if (!status.ok()) return done(status);
  append_strand_->Wake();
}

void MapRuntime::RequestCommit(MapSequence target) {
  integrator_.RequestCommit(target);
  map_strand_->Wake();
}

LogGroup MapRuntime::TakeGroup(std::vector<PendingClasses>* classes) {
  LogGroup group(key_, durable_head(), &sessions_, clock_.Now());
  *classes = class_log_.TakeQueued();
  for (const PendingClasses& pending : *classes) group.AddClasses(pending.classes);
  for (PendingBatch& batch : queue_.PopFair(kMaxGroupFrames, kMaxGroupBytes)) {
    group.AddBatch(std::move(batch));
  }
  group.Seal();
  return group;
}

/// Appends all waiting batches as one group. During its disk sync the next group accumulates.
Strand::Next MapRuntime::AppendStep() {
  std::vector<PendingClasses> classes;
  LogGroup group = TakeGroup(&classes);
  if (group.empty()) return Strand::Next::Never();
  absl::Status status = CheckUploads();
  // An exceeded memory limit refuses new uploads; frames that are already in the queue are
  // accepted.
  if (ReasonOf(status) == reason::kMapBytes || ReasonOf(status) == reason::kMemoryLow) {
    status = absl::OkStatus();
  }
  if (status.ok()) status = dependencies_.store->Append(group.append());
  if (ReasonOf(status) == reason::kDiskLow) status = WithRetryDelay(status, kDiskRetry.count());
  if (status.ok()) RecordAppend(group);
  // A full disk fails only this group. NotFound means that the map was deleted. Any other error
  // stops the map; the condition is set before the error is reported, so that clients that react to
  // the error find the new condition.
  const bool stops_map =
      !status.ok() && ReasonOf(status) != reason::kDiskLow && !absl::IsNotFound(status);
  if (stops_map) Fail(status);
  // DURABLE is reported to the uploads before the integrator can report INTEGRATED.
  group.Report(status);
  for (const PendingClasses& pending : classes) pending.done(status);
  if (status.ok()) {
    integrator_.Push(group.TakeEntries());
    group.AwaitCommit(&waiters_);
    map_strand_->Wake();
    return queue_.waiting_frames() > 0 ? Strand::Next::Now() : Strand::Next::Never();
  }
  if (stops_map) map_strand_->Wake();
  return Strand::Next::Now();
}

/// Publishes the durable state: sessions, head of the log, classes.
void MapRuntime::RecordAppend(const LogGroup& group) {
  for (const auto& [name, session] : group.sessions()) sessions_.Update(session);
  durable_head_ = group.head().value();
  for (const LogEntry& entry : group.append().entries) class_log_.Append(entry.classes);
}

Strand::Next MapRuntime::MapStep() {
  switch (condition()) {
    case Condition::kOpening:
    case Condition::kReadOnly:
      return OpenStep();
    case Condition::kReady: {
      const MapIntegrator::StepResult result = integrator_.Step();
      if (result.status.ok()) return result.next;
      Fail(result.status);
      return NextTry();
    }
    default:
      return Strand::Next::Never();
  }
}

/// Opens the map, or reopens it after a failed write.
Strand::Next MapRuntime::OpenStep() {
  Store& store = *dependencies_.store;
  if (condition() == Condition::kReadOnly) {
    // While the disk is full, a reopening would fail again.
    if (absl::Status disk = store.CheckDisk(); !disk.ok()) {
      return Strand::Next::At(Strand::Clock::now() + kDiskRetry);
    }
  }
  const absl::StatusOr<StoredState> state = store.LoadMap(record());
  absl::Status status = state.status();
  if (state.ok()) status = AdoptState(*state);
  // The store may have opened the map for reading only.
  if (status.ok()) status = store.health(key_);
  if (!status.ok()) {
    Fail(status);
    return NextTry();
  }
  waiters_.Restart();
  queue_.Open();
  retry_delay_ = std::chrono::milliseconds(0);
  SetCondition(Condition::kReady, absl::OkStatus());
  return Strand::Next::Now();
}

absl::Status MapRuntime::AdoptState(const StoredState& state) {
  clock_.Continue(state.uptime);
  sessions_.Reset(state.sessions, state.snapshot.integrated());
  durable_head_ = state.durable_head.value();
  class_log_.Reset(state.durable_classes);
  if (absl::Status status = integrator_.Start(record(), state); !status.ok()) return status;
  Publish({std::make_shared<const MapSnapshot>(state.snapshot),
           state.commit,
           integrator_.Count(state.snapshot)});
  return absl::OkStatus();
}

/// Sets the condition after an error: read-only if the error is temporary, else quarantined or
/// damaged.
void MapRuntime::Fail(const absl::Status& status) {
  const bool is_readable = CheckReads().ok() || snapshot()->revision > Revision();
  // After an exception the map is reopened from the store. If the same entry fails repeatedly, the
  // integrator reports MAP_QUARANTINED.
  const bool is_internal = ReasonOf(status) == reason::kInternal && is_readable;
  if (is_internal || IsTemporary(status)) {
    SetCondition(Condition::kReadOnly,
                 is_internal ? MakeError(absl::StatusCode::kUnavailable,
                                         reason::kStoreReadOnly,
                                         std::string(status.message()))
                             : status);
  } else {
    spdlog::error("map {}: quarantined: {}", name_.ToString(), std::string(status.message()));
    SetCondition(is_readable ? Condition::kQuarantined : Condition::kDamaged, status);
  }
  RefuseUploads(status);
}

/// Returns the time of the next attempt to reopen the map; never if it would not help.
Strand::Next MapRuntime::NextTry() {
  if (condition() != Condition::kReadOnly) return Strand::Next::Never();
  retry_delay_ = std::clamp(2 * retry_delay_, kFirstRetry, kLongestRetry);
  return Strand::Next::At(Strand::Clock::now() + retry_delay_);
}

void MapRuntime::SetCondition(Condition condition, const absl::Status& reason) {
  std::vector<std::function<void()>> opened;
  {
    const absl::MutexLock lock(&mutex_);
    if (closed_) return;
    health_ = {condition, reason};
    if (condition != Condition::kOpening) opened.swap(when_opened_);
  }
  for (const std::function<void()>& callback : opened) callback();
}

void MapRuntime::Publish(PublishedRevision published) {
  const Revision revision = published.snapshot->revision;
  const MapSequence integrated = published.snapshot->integrated();
  PublishedRevision previous;
  {
    const absl::MutexLock lock(&mutex_);
    previous = std::exchange(published_, std::move(published));
  }
  waiters_.Notify(revision, integrated);
  dependencies_.on_published(key_);
}

/// Refuses waiting batches, commit waiters and reservations.
void MapRuntime::RefuseUploads(const absl::Status& status) {
  for (const PendingBatch& batch : queue_.Close(status)) batch.observer->OnFailed(status);
  waiters_.Fail(status);
  FrameBudget::Close(budget_account_);
  FrameBudget::Close(read_account_);
}

void MapRuntime::Close(const absl::Status& status,
                       bool commit,
                       const std::function<void()>& on_closed) {
  std::vector<std::function<void()>> opened;
  bool was_ready = false;
  {
    const absl::MutexLock lock(&mutex_);
    if (std::exchange(closed_, true)) return;
    was_ready = health_.condition == Condition::kReady;
    health_ = {Condition::kDeleted, status};
    opened.swap(when_opened_);
  }
  integrator_.Interrupt();
  RefuseUploads(status);
  for (const PendingClasses& pending : class_log_.Close(status)) pending.done(status);
  for (const std::function<void()>& callback : opened) callback();
  append_strand_->Stop([self = shared_from_this(), commit, was_ready, on_closed] {
    self->map_strand_->Stop([self, commit, was_ready, on_closed] {
      if (commit && was_ready) self->CommitOnClose();
      if (on_closed) on_closed();
    });
  });
}

void MapRuntime::CommitOnClose() {
  const absl::Status committed = integrator_.CommitNow();
  if (committed.ok()) return;
  spdlog::warn("map {}: the last commit failed; its frames are integrated at the next start: {}",
               name_.ToString(),
               std::string(committed.message()));
}

}  // namespace steadymap
