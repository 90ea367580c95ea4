#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "core/identifiers.h"
#include "server/store.h"

namespace steadymap {

/// Where a session stands.
struct SessionState {
  ClientSequence durable;     ///< All up to it are durable or were refused.
  ClientSequence integrated;  ///< All up to it are in a committed revision or were refused.
  Timestamp last_active;      ///< The epoch for a session that is not known.
};

/// The upload sessions of one map: which frames are known already, and how far they are integrated.
///
/// Only durable knowledge gets in: frames on their way to the log are not listed, so a frame may be
/// offered twice; the log's writer, which asks last, finds the second. Thread-safe.
class SessionTable {
 public:
  /// The sessions of a stored map whose newest revision is `revision`.
  SessionTable(const std::vector<SessionRecord>& sessions, Revision revision);

  /// The record of a session; a new one where it is not known.
  SessionRecord Get(const SessionName& name) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Whether the frame is durable or was refused.
  bool IsSettled(const SessionName& name, ClientSequence sequence) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes in a record that has become durable.
  void Update(const SessionRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Where a session stands while the map's newest revision is `revision`.
  SessionState State(const SessionName& name, Revision revision) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Forgets sessions that were last active before `before`.
  void ForgetIdle(Timestamp before) ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// All of the session up to `through` is in the map once `map_seq` is.
  struct Milestone {
    ClientSequence through;
    MapSequence map_seq;
  };

  struct Session {
    SessionRecord record;
    ClientSequence integrated;
    std::deque<Milestone> milestones;  ///< Beyond `integrated`; at most `kMaxMilestones`.
  };

  static void Advance(Session* session, Revision revision);
  static void AddMilestone(Session* session);

  mutable absl::Mutex mutex_;
  std::map<SessionName, Session> sessions_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
