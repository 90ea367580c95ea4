#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "core/map_counts.h"
#include "core/map_snapshot.h"
#include "server/commit_waiters.h"
#include "server/frame_budget.h"
#include "server/frame_queue.h"
#include "server/mapping_thread.h"
#include "server/server_config.h"
#include "server/session_table.h"
#include "server/store.h"

namespace steadymap {

/// One map while the server runs: its record, its published snapshot, and its frames' way from the
/// queue through the log into the map. Thread-safe.
///
/// A map whose content is damaged is quarantined: `condition()` says so, and nothing else of it may
/// be used.
class MapRuntime : public std::enable_shared_from_this<MapRuntime> {
 public:
  /// What maps need of the server; all of it outlives them.
  struct Surroundings {
    Store* store = nullptr;
    FrameBudget* budget = nullptr;
    CommitOptions commit;
    std::size_t queue_bytes = 0;  ///< Of one map.
    /// The map's queue has got frames; from any thread, without locks held.
    std::function<void(const std::shared_ptr<MapRuntime>&)> on_queued;
    /// The map has published a revision; from its thread, without locks held.
    std::function<void(MapKey)> on_published;
    /// Something has failed for good; from any thread, without locks held.
    std::function<void(const absl::Status&)> on_failure;
  };

  /// Loads the map from the store, and starts to integrate what its log holds beyond its newest
  /// revision. Never fails: a map that cannot be loaded has a `condition`.
  static std::shared_ptr<MapRuntime> Load(const MapRecord& record,
                                          const Surroundings& surroundings);

  /// Use `Load`.
  MapRuntime(const MapRecord& record, const StoredState& stored, const Surroundings& surroundings);
  ~MapRuntime();

  MapKey key() const { return key_; }

  const MapName& name() const { return name_; }

  /// Labels of the map's frames lie below this.
  std::size_t label_limit() const { return label_limit_; }

  MapRecord record() const ABSL_LOCKS_EXCLUDED(mutex_);
  void SetRecord(const MapRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);

  /// OK, or why nothing of the map can be used: `DataLoss` in quarantine, `NotFound` once deleted.
  absl::Status condition() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// OK, or why the map takes no frames: as `condition`, or a failed store, or `MAP_BYTES`.
  absl::Status CheckUploads() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest revision.
  std::shared_ptr<const MapSnapshot> snapshot() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Counts what the newest revision holds. Cost: a pass over all leaves once a revision.
  MapCounts Count() ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest frame in the log.
  MapSequence durable_head() const { return MapSequence(durable_head_.load()); }

  std::uint64_t refused_frames() const { return refused_frames_.load(); }

  void CountRefused(std::size_t frames) { refused_frames_ += frames; }

  SessionTable& sessions() { return sessions_; }

  CommitWaiters& waiters() { return waiters_; }

  const std::shared_ptr<FrameBudget::Account>& budget_account() const { return budget_account_; }

  /// Hands a batch to the log's writer. Errors: as `FrameQueue::Push`.
  absl::Status Enqueue(PendingBatch batch);

  /// The next batches for the log, fair between robots. For the log's writer.
  std::vector<PendingBatch> PopQueued(std::size_t max_frames) { return queue_.PopFair(max_frames); }

  /// Frames that wait for the log, and those that wait for integration.
  std::size_t queued_frames() const { return queue_.waiting_frames(); }

  std::size_t unmapped_frames() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The log has come to `head`. For the log's writer, before it tells anybody.
  void AdvanceHead(MapSequence head) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes the frames up to the log's head for integration. For the log's writer.
  void TakeDurable(std::vector<LoggedFrame> frames) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Commits without delay once the frame `target` is integrated.
  void RequestCommit(MapSequence target) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the map's thread and refuses everything with `status`; whoever waits gets it too. What is
  /// integrated is committed before if `commit`. Blocks for about a frame's time.
  void Close(const absl::Status& status, bool commit) ABSL_LOCKS_EXCLUDED(mutex_);

  /// When the map's thread last showed that it goes on; none without a running thread.
  std::optional<Heartbeat::Clock::time_point> last_progress() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void StartMapping() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Publish(const std::shared_ptr<const MapSnapshot>& snapshot) ABSL_LOCKS_EXCLUDED(mutex_);
  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void RefuseWaiting(const absl::Status& status);

  const MapKey key_;
  const MapName name_;
  const std::size_t label_limit_;
  const Surroundings surroundings_;
  const std::shared_ptr<FrameBudget::Account> budget_account_;
  SessionTable sessions_;
  CommitWaiters waiters_;
  FrameQueue queue_;
  std::atomic<std::uint64_t> durable_head_;
  std::atomic<std::uint64_t> refused_frames_ = 0;

  mutable absl::Mutex mutex_;
  MapRecord record_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const MapSnapshot> snapshot_ ABSL_GUARDED_BY(mutex_);
  absl::Status condition_ ABSL_GUARDED_BY(mutex_);
  absl::Status upload_failure_ ABSL_GUARDED_BY(mutex_);
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  std::size_t memory_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Kept where there is a byte budget.
  std::optional<Revision> counted_revision_ ABSL_GUARDED_BY(mutex_);
  MapCounts counts_ ABSL_GUARDED_BY(mutex_);
  std::unique_ptr<MappingThread> mapping_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
