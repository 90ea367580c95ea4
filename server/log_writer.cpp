#include "server/log_writer.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/time/time.h>
#include <spdlog/spdlog.h>

#include "core/error.h"
#include "server/system_clock.h"

namespace steadymap {
namespace {

// Frames of one map in a group: large enough that a sync serves many, small enough that another
// map's frames do not wait long for their turn.
constexpr std::size_t kMaxGroupFrames = 64;

}  // namespace

struct LogWriter::MapGroup {
  /// A batch, with what has been found out about it.
  struct StagedBatch {
    PendingBatch batch;
    BatchProgress progress;
    absl::Status status;  ///< Not OK: it was refused as a whole.
  };

  std::shared_ptr<MapRuntime> map;
  std::vector<StagedBatch> batches;
  std::map<SessionName, SessionRecord> sessions;  ///< As they will be.
  std::vector<LoggedFrame> frames;                ///< What is new, with its place.
  MapSequence head;                               ///< Of the log, after this.
  LogAppend append;

  /// Finds the place of every frame of `batch`, and leaves out what is known already.
  void Stage(PendingBatch batch, Timestamp now);

 private:
  absl::Status Settle(const PendingBatch& batch, SessionRecord* session) const;
};

void LogWriter::MapGroup::Stage(PendingBatch batch, Timestamp now) {
  const auto [staged, is_new] = sessions.try_emplace(batch.session);
  if (is_new) staged->second = map->sessions().Get(batch.session);
  SessionRecord& session = staged->second;
  BatchProgress progress;
  progress.through = batch.last;
  progress.frames = batch.credit_frames;
  progress.bytes = batch.credit_bytes;

  SessionRecord settled = session;
  settled.last_active = now;
  absl::Status status = Settle(batch, &settled);
  if (status.ok()) {
    for (PendingFrame& pending : batch.frames) {
      if (session.settled.Contains(pending.sequence)) continue;
      head = head.Next();
      append.frames.push_back({head,
                               batch.session.robot,
                               pending.frame.capture_time,
                               pending.frame.T_world_camera,
                               std::move(pending.packed)});
      frames.push_back({head, std::move(pending.frame), std::move(pending.reservation)});
      settled.last_map_seq = head;
    }
    session = std::move(settled);
    // For frames that were all known, the session's newest stands: it cannot be before theirs.
    progress.map_seq = session.last_map_seq;
  }
  batch.frames.clear();
  batches.push_back({std::move(batch), progress, std::move(status)});
}

absl::Status LogWriter::MapGroup::Settle(const PendingBatch& batch, SessionRecord* session) const {
  if (batch.in_order) {
    if (session->settled.contiguous_end() < batch.predecessor) {
      return absl::AbortedError(absl::StrCat("the frames up to client sequence ",
                                             batch.predecessor.value(),
                                             ", which come before these, were not stored"));
    }
    session->settled.InsertThrough(batch.last);
    return absl::OkStatus();
  }
  for (const PendingFrame& pending : batch.frames) {
    if (absl::Status status = session->settled.Insert(pending.sequence); !status.ok()) {
      return status;
    }
  }
  for (const ClientSequence refused : batch.refused) {
    if (absl::Status status = session->settled.Insert(refused); !status.ok()) return status;
  }
  return absl::OkStatus();
}

LogWriter::LogWriter(Store* store, std::function<void(const absl::Status&)> on_failure)
    : store_(store), on_failure_(std::move(on_failure)), thread_([this] { Run(); }) {}

LogWriter::~LogWriter() { Stop(); }

void LogWriter::Notify(const std::shared_ptr<MapRuntime>& map) {
  const absl::MutexLock lock(&mutex_);
  ready_.emplace(map->key(), map);
}

void LogWriter::Stop() {
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

void LogWriter::Run() {
  while (true) {
    heartbeat_.Beat();
    std::vector<MapGroup> groups = TakeGroups();
    if (!groups.empty()) Write(std::move(groups));
    const absl::MutexLock lock(&mutex_);
    if (stopping_ && ready_.empty()) return;
  }
}

std::vector<LogWriter::MapGroup> LogWriter::TakeGroups() {
  std::map<MapKey, std::shared_ptr<MapRuntime>> ready;
  {
    const absl::MutexLock lock(&mutex_);
    mutex_.AwaitWithTimeout(absl::Condition(this, &LogWriter::HasWork),
                            absl::FromChrono(Heartbeat::kMaxInterval));
    ready.swap(ready_);
  }
  std::vector<MapGroup> groups;
  const Timestamp now = Now();
  for (auto& [key, map] : ready) {
    MapGroup group;
    group.map = map;
    group.head = map->durable_head();
    for (PendingBatch& batch : map->PopQueued(kMaxGroupFrames)) group.Stage(std::move(batch), now);
    // What did not fit into this group goes into the next one.
    if (map->queued_frames() > 0) Notify(map);
    if (group.batches.empty()) continue;
    group.append.map = key;
    group.append.append_time = now;
    for (const auto& [name, session] : group.sessions) group.append.sessions.push_back(session);
    groups.push_back(std::move(group));
  }
  return groups;
}

void LogWriter::Write(std::vector<MapGroup> groups) {
  std::vector<LogAppend> appends;
  appends.reserve(groups.size());
  for (MapGroup& group : groups) appends.push_back(std::move(group.append));
  absl::Status status = store_->AppendFrames(appends);
  const bool one_map_spoils = groups.size() > 1 && !status.ok() && !absl::IsUnavailable(status);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    // One map that was just deleted must not cost the others their frames.
    if (one_map_spoils) status = store_->AppendFrames({appends[i]});
    if (!status.ok()) {
      spdlog::warn("map {}: the log took no frames: {}",
                   groups[i].map->name().ToString(),
                   std::string(status.message()));
      on_failure_(status);
    }
    Finish(&groups[i], status);
  }
}

void LogWriter::Finish(MapGroup* group, const absl::Status& status) {
  if (status.ok()) {
    for (const auto& [name, session] : group->sessions) group->map->sessions().Update(session);
    group->map->AdvanceHead(group->head);
  }
  // DURABLE goes out before the mapping thread can say INTEGRATED.
  for (const MapGroup::StagedBatch& staged : group->batches) {
    const absl::Status& refusal = status.ok() ? staged.status : status;
    if (refusal.ok()) {
      staged.batch.observer->OnDurable(staged.progress);
    } else {
      staged.batch.observer->OnFailed(refusal);
    }
  }
  if (!status.ok()) return;
  group->map->TakeDurable(std::move(group->frames));
  for (MapGroup::StagedBatch& staged : group->batches) {
    if (!staged.status.ok()) continue;
    group->map->waiters().Add(std::move(staged.batch.observer), staged.progress);
  }
}

}  // namespace steadymap
