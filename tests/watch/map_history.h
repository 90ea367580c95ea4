#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "core/map/map_delta.h"
#include "core/map/map_filter.h"

namespace steadymap {

/// Every commit that a store took of one map, in order. Outlives servers and stores. Thread-safe.
class MapHistory {
 public:
  /// Notes a commit; it must follow the one before.
  void Add(const MapDelta& delta) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The commit behind revision `from`; null if there is none yet.
  std::shared_ptr<const MapDelta> After(Revision from) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest revision.
  Revision head() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Commits that did not follow the one before: the store has broken its promise.
  std::size_t gaps() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  mutable absl::Mutex mutex_;
  std::map<Revision, std::shared_ptr<const MapDelta>> commits_
      ABSL_GUARDED_BY(mutex_);  ///< By from.
  Revision head_ ABSL_GUARDED_BY(mutex_);
  std::size_t gaps_ ABSL_GUARDED_BY(mutex_) = 0;
};

/// What a watcher has, or ought to have: objects as they are on the wire, leaves as they are
/// packed.
struct WatchedContent {
  std::map<ObjectId, std::string> objects;
  std::map<LeafKey, std::string> leaves;

  friend bool operator==(const WatchedContent&, const WatchedContent&) = default;
};

/// A map replayed from its history, to compare with at any revision. Goes forward only.
class MapReplay {
 public:
  MapReplay(const MapHistory* history, const VoxelScale& scale)
      : history_(history), scale_(scale) {}

  /// Goes on to a revision; false if the history has no such revision.
  bool GoTo(Revision revision);

  Revision revision() const { return revision_; }

  /// Of the newest frame at the replay's revision.
  Timestamp last_capture_time() const { return last_capture_time_; }

  /// What the filter shows at the replay's revision.
  WatchedContent Shown(const MapFilter& filter) const;

  /// The state of an object at the replay's revision; null if there is none.
  const ObjectState* Find(ObjectId id) const;

  /// The events of the commits that `GoTo` has gone through since it was last asked, with the
  /// numbers that the store gave them.
  struct NumberedEvent {
    EventNumber number;
    ObjectEvent event;
  };

  std::vector<NumberedEvent> TakeEvents();

 private:
  const MapHistory* history_;
  VoxelScale scale_;
  Revision revision_;
  Timestamp last_capture_time_;
  EventNumber last_event_;
  std::map<ObjectId, ObjectState> objects_;
  std::map<LeafKey, std::string> leaves_;
  std::vector<NumberedEvent> events_;
};

}  // namespace steadymap
