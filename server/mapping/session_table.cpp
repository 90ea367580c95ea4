#include "server/mapping/session_table.h"

#include <utility>

namespace steadymap {
namespace {

// Further milestones are merged, so that the memory of a session is bounded even if its state is
// never requested.
constexpr std::size_t kMaxMilestones = 1024;

// Sessions in which every frame so far was refused: many more than real robots have, few enough to
// bound the memory if a client invents session names.
constexpr std::size_t kMaxFrameless = 256;

}  // namespace

SessionTable::SessionTable(const std::vector<SessionRecord>& sessions, MapSequence integrated) {
  Reset(sessions, integrated);
}

void SessionTable::Reset(const std::vector<SessionRecord>& sessions, MapSequence integrated) {
  const absl::MutexLock lock(&mutex_);
  sessions_.clear();
  sessions_without_frames_.clear();
  for (const SessionRecord& record : sessions) {
    Session session{record, ClientSequence(0), {}};
    AddMilestone(&session);
    Advance(&session, integrated);
    sessions_.emplace(record.name, std::move(session));
  }
}

SessionRecord SessionTable::Get(const SessionName& name) const {
  const absl::MutexLock lock(&mutex_);
  const auto session = sessions_.find(name);
  if (session != sessions_.end()) return session->second.record;
  SessionRecord record;
  record.name = name;
  return record;
}

std::optional<SessionRecord> SessionTable::NewestOf(const SensorName& sensor) const {
  const absl::MutexLock lock(&mutex_);
  std::optional<SessionRecord> newest;
  for (const auto& [name, session] : sessions_) {
    if (name.sensor != sensor) continue;
    if (!newest || session.record.last_active > newest->last_active) newest = session.record;
  }
  return newest;
}

bool SessionTable::IsSettled(const SessionName& name, ClientSequence sequence) const {
  const absl::MutexLock lock(&mutex_);
  const auto session = sessions_.find(name);
  return session != sessions_.end() && session->second.record.settled.Contains(sequence);
}

void SessionTable::Update(const SessionRecord& record) {
  const absl::MutexLock lock(&mutex_);
  const auto [entry, is_new] = sessions_.try_emplace(record.name);
  entry->second.record = record;
  AddMilestone(&entry->second);
  if (!is_new || record.last_map_seq > MapSequence(0)) return;
  sessions_without_frames_.push_back(record.name);
  DropOldest();
}

void SessionTable::DropOldest() {
  while (sessions_without_frames_.size() > kMaxFrameless) {
    const auto oldest = sessions_.find(sessions_without_frames_.front());
    if (oldest != sessions_.end() && oldest->second.record.last_map_seq == MapSequence(0)) {
      sessions_.erase(oldest);
    }
    sessions_without_frames_.pop_front();
  }
}

SessionState SessionTable::State(const SessionName& name, MapSequence integrated) {
  const absl::MutexLock lock(&mutex_);
  const auto session = sessions_.find(name);
  if (session == sessions_.end()) return {};
  Advance(&session->second, integrated);
  return {session->second.record.settled.contiguous_end(),
          session->second.integrated,
          session->second.record.last_active_time};
}

void SessionTable::ForgetIdle(MapUptime before, const std::set<SessionName>& in_use) {
  const absl::MutexLock lock(&mutex_);
  std::erase_if(sessions_, [&](const auto& session) {
    return session.second.record.last_active < before && !in_use.contains(session.first);
  });
}

std::size_t SessionTable::size() const {
  const absl::MutexLock lock(&mutex_);
  return sessions_.size();
}

void SessionTable::Advance(Session* session, MapSequence integrated) {
  while (!session->milestones.empty() && session->milestones.front().map_seq <= integrated) {
    session->integrated = session->milestones.front().through;
    session->milestones.pop_front();
  }
}

void SessionTable::AddMilestone(Session* session) {
  const Milestone milestone{session->record.settled.contiguous_end(), session->record.last_map_seq};
  std::deque<Milestone>& milestones = session->milestones;
  if (milestones.size() >= kMaxMilestones) milestones.pop_back();
  milestones.push_back(milestone);
}

}  // namespace steadymap
