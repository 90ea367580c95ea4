#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "core/types/identifiers.h"
#include "server/store/model/store.h"

namespace steadymap {

/// The progress of a session.
struct SessionState {
  ClientSequence durable;     ///< All frames up to it are durable or refused.
  ClientSequence integrated;  ///< All frames up to it are in a committed revision or refused.
  Timestamp last_active;      ///< Server time of the last frame; the epoch for an unknown session.
};

/// The upload sessions of one map: the known frames, and how far they are integrated.
///
/// Of the sessions without a durable frame only a bounded number, the newest, is stored. Forgetting
/// one does not cause duplicates.
///
/// Contains durable state only. Frames that wait for the log are not listed, so a frame can be
/// uploaded twice; `LogGroup` drops the second one just before the write. Thread-safe.
class SessionTable {
 public:
  SessionTable() = default;

  /// Makes the table of a stored map that contains the entries up to `integrated`.
  SessionTable(const std::vector<SessionRecord>& sessions, MapSequence integrated);

  /// Returns the record of a session; a new record if the session is unknown.
  SessionRecord Get(const SessionName& name) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the record of the sensor's session that was active last; none if there is none.
  std::optional<SessionRecord> NewestOf(const SensorName& sensor) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// True if the frame is durable or was refused.
  bool IsSettled(const SessionName& name, ClientSequence sequence) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Stores a record that has become durable.
  void Update(const SessionRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the progress of a session, if the map contains the entries up to `integrated`.
  SessionState State(const SessionName& name, MapSequence integrated) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Removes sessions that were last active before `before`, except those in `in_use`.
  void ForgetIdle(MapUptime before, const std::set<SessionName>& in_use)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Replaces all sessions by the stored ones, after the map was reopened.
  void Reset(const std::vector<SessionRecord>& sessions, MapSequence integrated)
      ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// All of the session up to `through` is in the map once the entry `map_seq` is.
  struct Milestone {
    ClientSequence through;
    MapSequence map_seq;
  };

  /// Removes the oldest sessions without a durable frame if there are too many.
  void DropOldest() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  struct Session {
    SessionRecord record;
    ClientSequence integrated;
    std::deque<Milestone> milestones;  ///< Milestones after `integrated`; at most `kMaxMilestones`.
  };

  static void Advance(Session* session, MapSequence integrated);
  static void AddMilestone(Session* session);

  mutable absl::Mutex mutex_;
  std::map<SessionName, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  /// Sessions added without a durable frame, oldest first; some may have gained one since.
  std::deque<SessionName> sessions_without_frames_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
