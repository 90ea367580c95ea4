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

/// An open watch. Called from any thread, without locks held. Must not block.
class ActiveWatch {
 public:
  virtual ~ActiveWatch() = default;

  /// Reports a newer revision of the map.
  virtual void Wake() = 0;

  /// Ends the watch with a goodbye message after all committed revisions have been sent.
  virtual void Drain() = 0;

  /// Ends the watch with `status`, after the pending message.
  virtual void End(const absl::Status& status) = 0;

  /// Ends the watch immediately, even if a message is pending.
  virtual void Cancel() = 0;

  /// Returns the revision that the watcher certainly has.
  virtual Revision revision() const = 0;

  /// Returns the step that is being sent; null between steps.
  virtual std::shared_ptr<WatchMessages> step() const = 0;

  /// Returns the start of the pending write; the infinite future if none is pending.
  virtual absl::Time sending_since() const = 0;
};

/// All open watches. Wakes them when their map changes, and makes the steps that they share. Stores
/// only the revision of a watch and no data for it: a slow watcher receives a longer step. For each
/// watched map it keeps the last few snapshots to compute patches of leaves. Thread-safe.
class WatchHub {
 public:
  /// The parts of the server that the hub uses. All of them must outlive the hub.
  struct Dependencies {
    Store* store = nullptr;
    std::size_t max_watches = 0;
    /// A watch whose pending message is older than this has stalled.
    absl::Duration stall_timeout = absl::InfiniteDuration();
    /// A stalled watch is cancelled after this additional time.
    absl::Duration stall_grace = absl::ZeroDuration();
  };

  explicit WatchHub(const Dependencies& dependencies) : dependencies_(dependencies) {}

  /// Adds a watch. Errors: `Unavailable` with reason `DRAINING`; `ResourceExhausted` with reason
  /// `QUEUE_FULL`.
  absl::Status Enter(MapKey map, std::shared_ptr<ActiveWatch> watch) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Removes a watch. With the last watch of a map its shared steps and recent snapshots are
  /// released.
  void Leave(MapKey map, const std::shared_ptr<ActiveWatch>& watch) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Wakes the watches of a map after it has published a revision.
  void OnCommit(MapKey map) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends stalled watches with reason `SLOW_CONSUMER`. Must be called periodically. gRPC sends the
  /// status after the pending message, so the watcher receives it when it reads again. After
  /// `stall_grace` the watch is cancelled, and the watcher receives no reason.
  void EndStalled() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Releases the held steps that have expired at `now`. Must be called periodically.
  void DropHeld(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the oldest revision among the watches of a map; none without watches.
  std::optional<Revision> OldestWatched(MapKey map) const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the watches of a map and releases its held steps.
  void EndMap(MapKey map, const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Refuses new watches and drains all open ones.
  void Drain() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Waits until all watches have ended. Returns false at `deadline`.
  bool AwaitEmpty(absl::Time deadline) ABSL_LOCKS_EXCLUDED(mutex_);

  void CancelAll() ABSL_LOCKS_EXCLUDED(mutex_);

  std::size_t watch_count() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The position of a watcher and the revision that it requests.
  struct StepRequest {
    WatchScope scope;
    MapFilter filter;
    std::size_t max_message_bytes = 0;
    bool takes_patches = false;  ///< Patches of leaves instead of whole leaves.
    bool as_snapshot = false;    ///< All data that the filter accepts, not only the changes.
    WatchPosition before;
    std::shared_ptr<const ShownObjects> shown;  ///< Objects shown at `before`; null: unknown.
    PublishedRevision to;
    Cancellation cancellation{};  ///< Cancelled if the watcher disconnects.
  };

  /// Returns the messages that bring a watcher to the requested revision. Equal requests share the
  /// same messages. Errors: `OutOfRange` with reason `REVISION_COMPACTED`; `Cancelled`; those of
  /// the store.
  absl::StatusOr<std::shared_ptr<WatchMessages>> FindStep(const StepRequest& request)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Keeps a step for one minute after a watch was interrupted in it, so that the watcher can
  /// resume within the step. Keeps the last 32 steps. Must be called before `Leave`.
  void Hold(std::shared_ptr<WatchMessages> step) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns a step that is held, is being sent, or was recently sent completely; null if there is
  /// none. Covers watchers that have disconnected unnoticed or have lost sent messages.
  std::shared_ptr<WatchMessages> FindHeld(const StepKey& key) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// A step that is being made or is complete.
  struct SharedStep {
    StepKey key;
    absl::Mutex mutex;
    std::shared_ptr<WatchMessages> messages ABSL_GUARDED_BY(mutex);
  };

  /// A step that a disconnected watcher may resume.
  struct HeldStep {
    std::shared_ptr<WatchMessages> messages;
    absl::Time until;
  };

  struct WatchedMap {
    std::set<std::shared_ptr<ActiveWatch>> watches;
    /// Snapshots at the end of the last steps, newest first; the bases of patches.
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
  std::map<MapKey, WatchedMap> maps_ ABSL_GUARDED_BY(mutex_);  ///< Maps with watches.
  std::size_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  std::deque<std::shared_ptr<SharedStep>> steps_ ABSL_GUARDED_BY(mutex_);  ///< Newest first.
  std::deque<HeldStep> held_ ABSL_GUARDED_BY(mutex_);                      ///< Newest first.
};

}  // namespace steadymap
