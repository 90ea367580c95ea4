#include "server/map_runtime.h"

#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/error.h"

namespace steadymap {
namespace {

// What 64 streams of 64 frames may have under way; the log takes them in a few milliseconds.
constexpr std::size_t kMaxQueuedFrames = 4096;

/// How a map commits: as the server does, unless the map says otherwise.
CommitOptions CommitOf(const MapRecord& record, const MapRuntime::Surroundings& surroundings) {
  CommitOptions commit = surroundings.commit;
  if (record.max_commit_delay.count() > 0) commit.max_delay = record.max_commit_delay;
  return commit;
}

}  // namespace

std::shared_ptr<MapRuntime> MapRuntime::Load(const MapRecord& record,
                                             const Surroundings& surroundings) {
  const absl::StatusOr<StoredState> stored = record.condition.ok()
                                                 ? surroundings.store->LoadMap(record)
                                                 : absl::StatusOr<StoredState>(record.condition);
  if (!stored.ok()) {
    spdlog::error(
        "map {}: quarantined: {}", record.name.ToString(), std::string(stored.status().message()));
    auto map = std::make_shared<MapRuntime>(record, StoredState(), surroundings);
    map->Close(stored.status(), /*commit=*/false);
    return map;
  }
  auto map = std::make_shared<MapRuntime>(record, *stored, surroundings);
  if (stored->durable_head.value() > stored->snapshot.revision.value()) {
    const absl::MutexLock lock(&map->mutex_);
    map->StartMapping();
  }
  return map;
}

MapRuntime::MapRuntime(const MapRecord& record,
                       const StoredState& stored,
                       const Surroundings& surroundings)
    : key_(record.key),
      name_(record.name),
      label_limit_(record.config.label_limit()),
      surroundings_(surroundings),
      budget_account_(surroundings.budget->OpenAccount(surroundings.queue_bytes)),
      sessions_(stored.sessions, stored.snapshot.revision),
      waiters_(stored.snapshot.revision),
      queue_(kMaxQueuedFrames),
      durable_head_(stored.durable_head.value()),
      record_(record),
      snapshot_(std::make_shared<const MapSnapshot>(stored.snapshot)) {
  if (record.byte_budget > 0) memory_bytes_ = VolumeBytes(stored.snapshot);
}

MapRuntime::~MapRuntime() {
  Close(MakeError(absl::StatusCode::kUnavailable, reason::kDraining, "the server is stopping"),
        /*commit=*/false);
}

MapRecord MapRuntime::record() const {
  const absl::MutexLock lock(&mutex_);
  return record_;
}

void MapRuntime::SetRecord(const MapRecord& record) {
  const std::shared_ptr<const MapSnapshot> newest = snapshot();
  const std::size_t memory_bytes = record.byte_budget > 0 ? VolumeBytes(*newest) : std::size_t{0};
  const absl::MutexLock lock(&mutex_);
  record_ = record;
  memory_bytes_ = memory_bytes;
  if (mapping_ != nullptr) mapping_->SetMaxDelay(CommitOf(record, surroundings_).max_delay);
}

absl::Status MapRuntime::condition() const {
  const absl::MutexLock lock(&mutex_);
  return condition_;
}

absl::Status MapRuntime::CheckUploads() const {
  const absl::MutexLock lock(&mutex_);
  if (!condition_.ok()) return condition_;
  if (!upload_failure_.ok()) return upload_failure_;
  if (record_.byte_budget == 0 || memory_bytes_ <= record_.byte_budget) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kMapBytes,
                   absl::StrCat("the map's volumes take ",
                                memory_bytes_,
                                " bytes, more than its byte_budget of ",
                                record_.byte_budget));
}

std::shared_ptr<const MapSnapshot> MapRuntime::snapshot() const {
  const absl::MutexLock lock(&mutex_);
  return snapshot_;
}

MapCounts MapRuntime::Count() {
  const std::shared_ptr<const MapSnapshot> counted = snapshot();
  {
    const absl::MutexLock lock(&mutex_);
    if (counted_revision_ == counted->revision) return counts_;
  }
  const MapCounts counts = CountMap(*counted);
  const absl::MutexLock lock(&mutex_);
  counted_revision_ = counted->revision;
  counts_ = counts;
  return counts;
}

absl::Status MapRuntime::Enqueue(PendingBatch batch) {
  absl::Status status = queue_.Push(std::move(batch));
  if (status.ok()) surroundings_.on_queued(shared_from_this());
  return status;
}

std::size_t MapRuntime::unmapped_frames() const {
  const absl::MutexLock lock(&mutex_);
  return mapping_ != nullptr ? mapping_->waiting_frames() : 0;
}

void MapRuntime::AdvanceHead(MapSequence head) {
  const absl::MutexLock lock(&mutex_);
  if (closed_ || head == durable_head()) return;
  // The thread starts from the head before: what follows comes through its inbox.
  if (mapping_ == nullptr) StartMapping();
  durable_head_ = head.value();
}

void MapRuntime::TakeDurable(std::vector<LoggedFrame> frames) {
  const absl::MutexLock lock(&mutex_);
  if (mapping_ != nullptr) mapping_->Push(std::move(frames));
}

void MapRuntime::RequestCommit(MapSequence target) {
  const absl::MutexLock lock(&mutex_);
  if (mapping_ != nullptr) mapping_->RequestCommit(target);
}

void MapRuntime::Close(const absl::Status& status, bool commit) {
  std::unique_ptr<MappingThread> mapping;
  {
    const absl::MutexLock lock(&mutex_);
    if (!closed_) condition_ = status;
    closed_ = true;
    mapping = std::move(mapping_);
  }
  if (mapping != nullptr) mapping->Stop(commit);
  RefuseWaiting(status);
}

std::optional<Heartbeat::Clock::time_point> MapRuntime::last_progress() const {
  const absl::MutexLock lock(&mutex_);
  if (mapping_ == nullptr || mapping_->ended()) return std::nullopt;
  return mapping_->heartbeat().last();
}

void MapRuntime::StartMapping() {
  absl::StatusOr<std::unique_ptr<Mapper>> mapper = Mapper::Create(record_.config);
  if (!mapper.ok()) {
    // The configuration was checked when the map was created, and the record carries a checksum.
    upload_failure_ = mapper.status();
    return;
  }
  mapping_ = std::make_unique<MappingThread>(
      MappingThread::Source{record_, *snapshot_, durable_head()},
      *std::move(mapper),
      surroundings_.store,
      CommitOf(record_, surroundings_),
      MappingThread::Listener{
          [this](const std::shared_ptr<const MapSnapshot>& snapshot) { Publish(snapshot); },
          [this](const absl::Status& status) { Fail(status); }});
}

void MapRuntime::Publish(const std::shared_ptr<const MapSnapshot>& snapshot) {
  const Revision revision = snapshot->revision;
  std::shared_ptr<const MapSnapshot> previous;
  bool has_budget = false;
  {
    const absl::MutexLock lock(&mutex_);
    has_budget = record_.byte_budget > 0;
    previous = std::exchange(snapshot_, snapshot);
  }
  if (has_budget) {
    const std::size_t memory_bytes = VolumeBytes(*snapshot);
    const absl::MutexLock lock(&mutex_);
    memory_bytes_ = memory_bytes;
  }
  waiters_.Notify(revision);
  surroundings_.on_published(key_);
}

void MapRuntime::Fail(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    upload_failure_ = status;
    if (absl::IsDataLoss(status) && !closed_) condition_ = status;
  }
  RefuseWaiting(status);
  surroundings_.on_failure(status);
}

void MapRuntime::RefuseWaiting(const absl::Status& status) {
  for (const PendingBatch& batch : queue_.Close(status)) batch.observer->OnFailed(status);
  waiters_.Fail(status);
  FrameBudget::Close(budget_account_);
}

}  // namespace steadymap
