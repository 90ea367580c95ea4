#include "server/session_table.h"

#include <iterator>
#include <utility>

namespace steadymap {
namespace {

// Milestones beyond this many are merged: a session that nobody asks about must not grow.
constexpr std::size_t kMaxMilestones = 1024;

}  // namespace

SessionTable::SessionTable(const std::vector<SessionRecord>& sessions, Revision revision) {
  for (const SessionRecord& record : sessions) {
    Session session{record, ClientSequence(0), {}};
    AddMilestone(&session);
    Advance(&session, revision);
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

bool SessionTable::IsSettled(const SessionName& name, ClientSequence sequence) const {
  const absl::MutexLock lock(&mutex_);
  const auto session = sessions_.find(name);
  return session != sessions_.end() && session->second.record.settled.Contains(sequence);
}

void SessionTable::Update(const SessionRecord& record) {
  const absl::MutexLock lock(&mutex_);
  Session& session = sessions_[record.name];
  session.record = record;
  AddMilestone(&session);
}

SessionState SessionTable::State(const SessionName& name, Revision revision) {
  const absl::MutexLock lock(&mutex_);
  const auto session = sessions_.find(name);
  if (session == sessions_.end()) return {};
  Advance(&session->second, revision);
  return {session->second.record.settled.contiguous_end(),
          session->second.integrated,
          session->second.record.last_active};
}

void SessionTable::ForgetIdle(Timestamp before) {
  const absl::MutexLock lock(&mutex_);
  for (auto session = sessions_.begin(); session != sessions_.end();) {
    const bool idle = session->second.record.last_active < before;
    session = idle ? sessions_.erase(session) : std::next(session);
  }
}

std::size_t SessionTable::size() const {
  const absl::MutexLock lock(&mutex_);
  return sessions_.size();
}

void SessionTable::Advance(Session* session, Revision revision) {
  while (!session->milestones.empty() &&
         session->milestones.front().map_seq.value() <= revision.value()) {
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
