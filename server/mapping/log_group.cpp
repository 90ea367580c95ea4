#include "server/mapping/log_group.h"

#include <utility>

#include <absl/strings/str_cat.h>

#include "server/process/system_clock.h"

namespace steadymap {

LogGroup::LogGroup(MapKey map, MapSequence head, const SessionTable* sessions, MapUptime uptime)
    : known_(sessions), uptime_(uptime), time_(Now()), head_(head) {
  append_.map = map;
  append_.uptime = uptime;
}

void LogGroup::AddClasses(std::vector<SemanticClass> classes) {
  head_ = head_.Next();
  append_.entries.push_back({head_, LogEntryKind::kClasses, {}, {}, classes});
  entries_.push_back({head_, LogEntryKind::kClasses, {}, std::move(classes), {}});
}

void LogGroup::AddBatch(PendingBatch batch) {
  const auto [staged, is_new] = sessions_.try_emplace(batch.session);
  if (is_new) staged->second = known_->Get(batch.session);
  SessionRecord& session = staged->second;
  BatchProgress progress;
  progress.through = batch.last;
  progress.frames = batch.credit_frames;
  progress.bytes = batch.credit_bytes;
  progress.ends_session = batch.ends_session;

  SessionRecord settled = session;
  settled.last_active = uptime_;
  settled.last_active_time = time_;
  absl::Status status = Settle(batch, &settled);
  if (status.ok()) {
    for (PendingFrame& pending : batch.frames) {
      if (session.settled.Contains(pending.sequence)) continue;
      head_ = head_.Next();
      append_.entries.push_back(
          {head_, LogEntryKind::kFrame, batch.session.sensor, std::move(pending.packed)});
      entries_.push_back({head_,
                          LogEntryKind::kFrame,
                          std::move(pending.frame),
                          {},
                          std::move(pending.reservation)});
      settled.last_map_seq = head_;
      settled.is_over = false;
    }
    if (batch.ends_session && !settled.is_over && settled.last_map_seq > MapSequence(0)) {
      AddSessionEnd(batch.session.sensor);
      settled.is_over = true;
    }
    session = std::move(settled);
    // If all frames were known already, reports the newest sequence of the session, which cannot be
    // smaller than theirs.
    progress.map_seq = session.last_map_seq;
    if (batch.ends_session) progress.map_seq = head_;
  }
  batch.frames.clear();
  batches_.push_back({std::move(batch), progress, std::move(status)});
}

void LogGroup::AddSessionEnd(const SensorName& sensor) {
  head_ = head_.Next();
  append_.entries.push_back({head_, LogEntryKind::kSessionEnd, sensor, {}});
  DurableEntry entry{head_, LogEntryKind::kSessionEnd, {}, {}, {}};
  entry.frame.source = sensor;
  entries_.push_back(std::move(entry));
}

absl::Status LogGroup::Settle(const PendingBatch& batch, SessionRecord* session) {
  if (batch.in_order) {
    if (session->settled.contiguous_end() < batch.predecessor) {
      return absl::AbortedError(absl::StrCat("the frames up to client sequence ",
                                             batch.predecessor.value(),
                                             ", which precede these frames, were not stored"));
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

void LogGroup::Seal() {
  for (const auto& [name, session] : sessions_) {
    if (session.last_map_seq > MapSequence(0)) append_.sessions.push_back(session);
  }
}

void LogGroup::Report(const absl::Status& status) const {
  for (const StagedBatch& staged : batches_) {
    const absl::Status& refusal = status.ok() ? staged.status : status;
    if (refusal.ok()) {
      staged.batch.observer->OnDurable(staged.progress);
    } else {
      staged.batch.observer->OnFailed(refusal);
    }
  }
}

void LogGroup::AwaitCommit(CommitWaiters* waiters) {
  for (StagedBatch& staged : batches_) {
    if (!staged.status.ok()) continue;
    waiters->Add(std::move(staged.batch.observer), staged.progress);
  }
}

}  // namespace steadymap
