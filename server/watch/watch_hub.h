#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include "core/types/cancellation.h"
#include "core/types/identifiers.h"
#include "server/mapping/map_runtime.h"
#include "server/store/model/store.h"
#include "server/watch/watch_messages.h"

namespace steadymap {

/// A watch under way. Called from any thread, without locks held; returns at once.
class ActiveWatch {
 public:
  virtual ~ActiveWatch() = default;

  /// The map has a newer revision.
  virtual void Wake() = 0;

  /// Says goodbye once everything that is committed has been sent.
  virtual void Drain() = 0;

  /// Ends with `status`, after the message that is on its way.
  virtual void End(const absl::Status& status) = 0;

  /// Ends now, whatever is on its way.
  virtual void Cancel() = 0;

  /// What the watcher has for certain.
  virtual Revision revision() const = 0;

  /// The step that it is being sent; null between steps.
  virtual std::shared_ptr<WatchMessages> step() const = 0;

  /// Since when a message has been on its way; infinitely far in the future if none is.
  virtual absl::Time sending_since() const = 0;
};

/// All watches under way: wakes them when their map changes, and makes the steps that they share.
/// Holds a watch's revision and nothing of its data: a watcher who is slow takes a longer step. Of
/// a map that is watched, it holds the last few snapshots, to tell what changed in a leaf.
/// Thread-safe.
class WatchHub {
 public:
  /// What the hub needs of the server; all of it outlives the hub.
  struct Dependencies {
    Store* store = nullptr;
    std::size_t max_watches = 0;
    /// A watch that takes a message for longer than this has stalled.
    absl::Duration stall_timeout = absl::InfiniteDuration();
    /// After so much more, it is given up.
    absl::Duration stall_grace = absl::ZeroDuration();
  };

  explicit WatchHub(const Dependencies& dependencies) : dependencies_(dependencies) {}

  /// Enters a watch. Errors: `Unavailable` with reason `DRAINING`; `ResourceExhausted` with reason
  /// `QUEUE_FULL`.
  absl::Status Enter(MapKey map, std::shared_ptr<ActiveWatch> watch) ABSL_LOCKS_EXCLUDED(mutex_);

  /// With the last watch of a map goes all that was kept for them.
  void Leave(MapKey map, const std::shared_ptr<ActiveWatch>& watch) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The map has published a revision: wakes its watches.
  void OnCommit(MapKey map) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the watches that have stalled, with reason `SLOW_CONSUMER`; to be called now and then.
  /// gRPC sends a status behind the message that is stuck and not before it, so the watcher learns
  /// of it when it reads again. One that is given up is cancelled, and learns nothing.
  void EndStalled() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Lets go of the steps that are held long enough at `now`; to be called now and then.
  void DropHeld(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  /// The revision of the watch that is furthest behind; none without watches.
  std::optional<Revision> OldestWatched(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the watches of a map, and forgets what was kept of it.
  void EndMap(MapKey map, const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Lets nobody in from now on, and asks all watches to say goodbye.
  void Drain() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Whether all watches have ended by `deadline`.
  bool AwaitEmpty(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);

  void CancelAll() ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t watch_count() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// What a watcher has and wants to have.
  struct StepRequest {
    WatchScope scope;
    MapFilter filter;
    std::size_t max_message_bytes = 0;
    bool takes_patches = false;  ///< Of leaves, in place of whole ones.
    bool as_snapshot = false;    ///< All that the filter shows, not what changed.
    WatchPosition before;
    std::shared_ptr<const ShownObjects> shown;  ///< At `before`; null: not known.
    PublishedRevision to;
    Cancellation cancellation{};  ///< Once this watcher has gone.
  };

  /// The messages that take a watcher to that revision; made once for all who ask the same.
  /// Errors: `OutOfRange` with reason `REVISION_COMPACTED`; `Cancelled`; what the store answers.
  absl::StatusOr<std::shared_ptr<WatchMessages>> FindStep(const StepRequest& request)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Keeps a step that a watch may have been cut off in, for a minute, so that its watcher can go
  /// on within it; the last few of them. To be called before the watch leaves.
  void Hold(std::shared_ptr<WatchMessages> step) ABSL_LOCKS_EXCLUDED(mutex_);

  /// A step that is held, or that a watch is being sent, or that one was sent to its end lately:
  /// the server may not know yet that its watcher has gone, or that part of it was lost on the way.
  /// Null if there is none.
  std::shared_ptr<WatchMessages> FindHeld(const StepKey& key) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// A step that is being made or was.
  struct SharedStep {
    StepKey key;
    absl::Mutex mutex;
    std::shared_ptr<WatchMessages> messages ABSL_GUARDED_BY(mutex);
  };

  /// A step whose watcher may come back.
  struct HeldStep {
    std::shared_ptr<WatchMessages> messages;
    absl::Time until;
  };

  struct WatchedMap {
    std::set<std::shared_ptr<ActiveWatch>> watches;
    /// What steps led to last, newest first: what the next ones are compared with.
    std::deque<std::shared_ptr<const MapSnapshot>> recent;
  };

  static StepKey KeyOf(const StepRequest& request);
  absl::StatusOr<std::shared_ptr<WatchMessages>> MakeStep(const StepRequest& request)
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::shared_ptr<SharedStep> ShareStep(const StepKey& key) ABSL_LOCKS_EXCLUDED(mutex_);
  void KeepRecent(MapKey map, const std::shared_ptr<const MapSnapshot>& snapshot)
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::shared_ptr<const MapSnapshot> FindRecent(MapKey map, Revision revision) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<std::shared_ptr<ActiveWatch>> WatchesOf(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);
  std::vector<std::shared_ptr<ActiveWatch>> All() const ABSL_LOCKS_EXCLUDED(mutex_);

  bool IsEmpty() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return count_ == 0; }

  const Dependencies dependencies_;
  mutable absl::Mutex mutex_;
  std::map<MapKey, WatchedMap> maps_ ABSL_GUARDED_BY(mutex_);  ///< Those with watches.
  std::size_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<std::shared_ptr<SharedStep>> steps_ ABSL_GUARDED_BY(mutex_);  ///< Newest first.
  std::deque<HeldStep> held_ ABSL_GUARDED_BY(mutex_);                      ///< Likewise.
};

}  // namespace steadymap
