#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "core/types/map_config.h"
#include "server/config/server_config.h"
#include "server/mapping/capture_clocks.h"
#include "server/mapping/class_log.h"
#include "server/mapping/commit_waiters.h"
#include "server/mapping/frame_queue.h"
#include "server/mapping/map_clock.h"
#include "server/mapping/map_integrator.h"
#include "server/mapping/session_table.h"
#include "server/process/frame_budget.h"
#include "server/process/memory_guard.h"
#include "server/process/strand.h"
#include "server/process/worker_pool.h"
#include "server/store/model/store.h"

namespace steadymap {

/// One map of a running server: its record, its published revision, and the path of its entries
/// from the queue through the log into the map. Thread-safe.
///
/// The work runs on thread pools that all maps share: log appends on one pool, on which threads
/// wait for the disk; opening, integration and commits on another.
class MapRuntime : public std::enable_shared_from_this<MapRuntime> {
 public:
  /// The parts of the server that maps use. All of them must outlive the maps.
  struct Dependencies {
    Store* store = nullptr;
    FrameBudget* budget = nullptr;       ///< Budget of frames.
    FrameBudget* read_budget = nullptr;  ///< Budget of undecoded messages.
    WorkerPool* log_pool = nullptr;
    WorkerPool* map_pool = nullptr;
    const MemoryGuard* memory = nullptr;  ///< Memory limit of the process.
    CommitOptions commit;
    std::size_t queue_bytes = 0;  ///< Queue limit of one map.
    /// Called after the map has published a revision, without locks held.
    std::function<void(MapKey)> on_published;
  };

  /// Condition of a map.
  enum class Condition {
    kOpening,      ///< The map is being read from disk.
    kReady,        ///< The map accepts frames and serves reads.
    kReadOnly,     ///< Reads work, writes fail temporarily; the map is reopened automatically.
    kQuarantined,  ///< Reads work; frames are refused until an operator repairs the map.
    kDamaged,      ///< The map cannot be read.
    kDeleted,
  };

  struct Health {
    Condition condition = Condition::kOpening;
    absl::Status reason;  ///< Reason for any condition other than `kReady`.
  };

  /// Makes the map and starts to open it. Never fails: if the map cannot be opened, its condition
  /// reports it.
  static std::shared_ptr<MapRuntime> Open(const MapRecord& record,
                                          const Dependencies& dependencies);

  /// Used only by `Open`.
  MapRuntime(const MapRecord& record, const Dependencies& dependencies);

  MapKey key() const { return key_; }

  const MapName& name() const { return name_; }

  MapRecord record() const ABSL_LOCKS_EXCLUDED(mutex_);
  void SetRecord(const MapRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);

  Health health() const ABSL_LOCKS_EXCLUDED(mutex_);

  Condition condition() const { return health().condition; }

  /// Calls `callback` once the opening has succeeded or failed: during this call, or from a thread
  /// of a pool.
  void WhenOpened(std::function<void()> callback) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns OK, or the reason for which the map cannot be read: `DataLoss` if damaged, `NotFound`
  /// if deleted, `Unavailable` while it is being opened.
  absl::Status CheckReads() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns OK, or the reason for which the map accepts no frames: an error of `CheckReads`, a
  /// store that cannot be written (`STORE_READ_ONLY`, `DISK_LOW`), `MAP_QUARANTINED`, `MAP_BYTES`
  /// or `MEMORY_LOW`.
  absl::Status CheckUploads() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the newest published revision; an empty one until the map is open.
  std::shared_ptr<const MapSnapshot> snapshot() const ABSL_LOCKS_EXCLUDED(mutex_);
  PublishedRevision published() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the values that are valid in label images: those of the class table at the head of the
  /// log.
  std::shared_ptr<const KnownLabels> labels() const { return class_log_.labels(); }

  /// Returns the class table at the head of the log.
  std::vector<SemanticClass> classes() const { return class_log_.classes(); }

  /// Returns the sequence of the newest entry in the log.
  MapSequence durable_head() const { return MapSequence(durable_head_.load()); }

  std::uint64_t refused_frames() const { return refused_frames_.load(); }

  void CountRefused(std::size_t frames) { refused_frames_ += frames; }

  SessionTable& sessions() { return sessions_; }

  CaptureClocks& capture_clocks() { return capture_clocks_; }

  const MapClock& clock() const { return clock_; }

  const std::shared_ptr<FrameBudget::Account>& budget_account() const { return budget_account_; }

  /// Account for upload messages that are not decoded yet.
  const std::shared_ptr<FrameBudget::Account>& read_account() const { return read_account_; }

  /// Queues a batch for the log. Errors: those of `FrameQueue::Push`.
  absl::Status Enqueue(PendingBatch batch);

  /// Ends the sessions of robots whose last frame is older than `max_silence`.
  void EndSilentSessions(std::chrono::seconds max_silence);

  /// Adds classes to the map's table. Calls `done` once they are durable, or with an error:
  /// `InvalidArgument` for classes that conflict with the table, or an error of `CheckUploads`.
  void AddClasses(std::vector<SemanticClass> classes,
                  const std::function<void(absl::Status)>& done);

  /// Number of frames that wait for the log.
  std::size_t queued_frames() const { return queue_.waiting_frames(); }

  std::size_t unintegrated_entries() const { return integrator_.waiting_entries(); }

  /// Commits without delay after the entry `target` is integrated.
  void RequestCommit(MapSequence target);

  /// Ends the work of the map: refuses new and waiting requests with `status`. If `commit`, commits
  /// the integrated entries. Calls `on_closed` after the last step and the commit, possibly before
  /// this call returns. Only the first call has an effect. Does not block.
  void Close(const absl::Status& status, bool commit, const std::function<void()>& on_closed)
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // Steps of the strands, on the pools.
  Strand::Next AppendStep() ABSL_LOCKS_EXCLUDED(mutex_);
  Strand::Next MapStep() ABSL_LOCKS_EXCLUDED(mutex_);
  Strand::Next OpenStep() ABSL_LOCKS_EXCLUDED(mutex_);
  Strand::Next NextTry() ABSL_LOCKS_EXCLUDED(mutex_);

  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  LogGroup TakeGroup(std::vector<PendingClasses>* classes) ABSL_LOCKS_EXCLUDED(mutex_);
  void RecordAppend(const LogGroup& group) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status AdoptState(const StoredState& state) ABSL_LOCKS_EXCLUDED(mutex_);
  void Publish(PublishedRevision published) ABSL_LOCKS_EXCLUDED(mutex_);
  void SetCondition(Condition condition, const absl::Status& reason) ABSL_LOCKS_EXCLUDED(mutex_);
  void RefuseUploads(const absl::Status& status);
  void CommitOnClose();

  const MapKey key_;
  const MapName name_;
  const Dependencies dependencies_;
  const std::shared_ptr<FrameBudget::Account> budget_account_;
  const std::shared_ptr<FrameBudget::Account> read_account_;
  MapClock clock_;
  SessionTable sessions_;
  CaptureClocks capture_clocks_;
  ClassLog class_log_;
  CommitWaiters waiters_;
  FrameQueue queue_;
  MapIntegrator integrator_;
  std::atomic<std::uint64_t> durable_head_ = 0;
  std::atomic<std::uint64_t> refused_frames_ = 0;
  std::chrono::milliseconds retry_delay_{0};  ///< Delay before the next `OpenStep`.
  std::shared_ptr<Strand> append_strand_;     ///< Set once, in `Open`.
  std::shared_ptr<Strand> map_strand_;        ///< Set once, in `Open`.

  mutable absl::Mutex mutex_;
  MapRecord record_ ABSL_GUARDED_BY(mutex_);
  Health health_ ABSL_GUARDED_BY(mutex_);
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::function<void()>> when_opened_ ABSL_GUARDED_BY(mutex_);
  PublishedRevision published_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
