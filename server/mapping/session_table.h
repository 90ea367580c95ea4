#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <set>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "core/types/identifiers.h"
#include "server/store/model/store.h"

namespace steadymap {

/// Where a session stands.
struct SessionState {
  ClientSequence durable;     ///< All up to it are durable or were refused.
  ClientSequence integrated;  ///< All up to it are in a committed revision or were refused.
  Timestamp last_active;      ///< By the server's clock; the epoch for a session that is not known.
};

/// The upload sessions of one map: which frames are known already, and how far they are integrated.
///
/// Of sessions without a durable frame a bounded number is remembered, the newest: nothing counts
/// twice because one is forgotten.
///
/// Only durable knowledge gets in: frames on their way to the log are not listed, so a frame may be
/// offered twice; the log's writer, which asks last, finds the second. Thread-safe.
class SessionTable {
 public:
  SessionTable() = default;

  /// The sessions of a stored map in which the entries up to `integrated` are.
  SessionTable(const std::vector<SessionRecord>& sessions, MapSequence integrated);

  /// The record of a session; a new one where it is not known.
  SessionRecord Get(const SessionName& name) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Whether the frame is durable or was refused.
  bool IsSettled(const SessionName& name, ClientSequence sequence) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes in a record that has become durable.
  void Update(const SessionRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Where a session stands while the map holds the entries up to `integrated`.
  SessionState State(const SessionName& name, MapSequence integrated) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Forgets sessions that were last active before `before`, but for those `in_use`.
  void ForgetIdle(MapUptime before, const std::set<SessionName>& in_use)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Replaces all that is known by what is durable, as after the map was opened anew.
  void Reset(const std::vector<SessionRecord>& sessions, MapSequence integrated)
      ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// All of the session up to `through` is in the map once `map_seq` is.
  struct Milestone {
    ClientSequence through;
    MapSequence map_seq;
  };

  /// Forgets the oldest of the sessions without a durable frame, where there are too many.
  void DropSurplus() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  struct Session {
    SessionRecord record;
    ClientSequence integrated;
    std::deque<Milestone> milestones;  ///< Beyond `integrated`; at most `kMaxMilestones`.
  };

  static void Advance(Session* session, MapSequence integrated);
  static void AddMilestone(Session* session);

  mutable absl::Mutex mutex_;
  std::map<SessionName, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  /// Oldest first; some may have gained a durable frame since.
  std::deque<SessionName> frameless_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
