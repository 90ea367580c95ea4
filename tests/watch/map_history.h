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

/// All commits of one map to a store, in order. Outlives servers and stores. Thread-safe.
class MapHistory {
 public:
  /// Adds a commit; it must follow the previous one.
  void Add(const MapDelta& delta) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the commit after revision `from`; null if there is none yet.
  std::shared_ptr<const MapDelta> After(Revision from) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the newest revision.
  Revision head() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Number of commits that did not follow the previous one: a fault of the store.
  std::size_t gaps() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  mutable absl::Mutex mutex_;
  std::map<Revision, std::shared_ptr<const MapDelta>> commits_
      ABSL_GUARDED_BY(mutex_);  ///< By from.
  Revision head_ ABSL_GUARDED_BY(mutex_);
  std::size_t gaps_ ABSL_GUARDED_BY(mutex_) = 0;
};

/// Actual or expected content of a watcher: objects in wire format, leaves packed.
struct WatchedContent {
  std::map<ObjectId, std::string> objects;
  std::map<LeafKey, std::string> leaves;

  friend bool operator==(const WatchedContent&, const WatchedContent&) = default;
};

/// A map replayed from its history, for comparison at any revision. Advances only.
class MapReplay {
 public:
  MapReplay(const MapHistory* history, const VoxelScale& scale)
      : history_(history), scale_(scale) {}

  /// Advances to a revision; false if the history does not contain it.
  bool GoTo(Revision revision);

  Revision revision() const { return revision_; }

  /// Capture time of the newest frame at the replay's revision.
  Timestamp last_capture_time() const { return last_capture_time_; }

  /// Returns the content that passes the filter at the replay's revision.
  WatchedContent Shown(const MapFilter& filter) const;

  /// Returns the state of an object at the replay's revision; null if it does not exist.
  const ObjectState* Find(ObjectId id) const;

  /// Returns the events of the commits that `GoTo` has passed since the last call, with the numbers
  /// of the store.
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
