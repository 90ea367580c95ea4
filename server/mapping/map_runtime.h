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

/// One map while the server runs: its record, its published revision, and its entries' way from the
/// queue through the log into the map. Thread-safe.
///
/// Its work is done on pools that all maps share: appending to the log on one, where threads wait
/// for the disk, and opening, integrating and committing on another.
class MapRuntime : public std::enable_shared_from_this<MapRuntime> {
 public:
  /// What maps need of the server; all of it outlives them.
  struct Dependencies {
    Store* store = nullptr;
    FrameBudget* budget = nullptr;       ///< Of frames.
    FrameBudget* read_budget = nullptr;  ///< Of messages that are not decoded yet.
    WorkerPool* log_pool = nullptr;
    WorkerPool* map_pool = nullptr;
    const MemoryGuard* memory = nullptr;  ///< Of the process.
    CommitOptions commit;
    std::size_t queue_bytes = 0;  ///< Of one map.
    /// The map has published a revision; without locks held.
    std::function<void(MapKey)> on_published;
  };

  /// How a map fares.
  enum class Condition {
    kOpening,      ///< It is being read from disk.
    kReady,        ///< It takes frames and answers.
    kReadOnly,     ///< It answers, but cannot be written to for now; it tries again by itself.
    kQuarantined,  ///< It answers, but takes no more frames until an operator has seen to it.
    kDamaged,      ///< It cannot be read.
    kDeleted,
  };

  struct Health {
    Condition condition = Condition::kOpening;
    absl::Status reason;  ///< Why it is another than `kReady`.
  };

  /// Makes the map and begins to open it. Never fails: a map that cannot be opened has a condition.
  static std::shared_ptr<MapRuntime> Open(const MapRecord& record,
                                          const Dependencies& dependencies);

  /// Use `Open`.
  MapRuntime(const MapRecord& record, const Dependencies& dependencies);

  MapKey key() const { return key_; }

  const MapName& name() const { return name_; }

  MapRecord record() const ABSL_LOCKS_EXCLUDED(mutex_);
  void SetRecord(const MapRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);

  Health health() const ABSL_LOCKS_EXCLUDED(mutex_);

  Condition condition() const { return health().condition; }

  /// Calls `callback` once the map is opened or cannot be: now, or from a thread of a pool.
  void WhenOpened(std::function<void()> callback) ABSL_LOCKS_EXCLUDED(mutex_);

  /// OK, or why the map cannot be read: `DataLoss` for a damaged one, `NotFound` once deleted,
  /// `Unavailable` while it is being opened.
  absl::Status CheckReads() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// OK, or why the map takes no frames: as `CheckReads`, or a store that cannot be written to
  /// (`STORE_READ_ONLY`, `DISK_LOW`), or `MAP_QUARANTINED`, or `MAP_BYTES`,
  /// or `MEMORY_LOW`.
  absl::Status CheckUploads() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest revision; an empty one until the map is opened.
  std::shared_ptr<const MapSnapshot> snapshot() const ABSL_LOCKS_EXCLUDED(mutex_);
  PublishedRevision published() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The values that label images may hold: those of the class table at the log's head.
  std::shared_ptr<const KnownLabels> labels() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// That class table.
  std::vector<SemanticClass> classes() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// The newest entry in the log.
  MapSequence durable_head() const { return MapSequence(durable_head_.load()); }

  std::uint64_t refused_frames() const { return refused_frames_.load(); }

  void CountRefused(std::size_t frames) { refused_frames_ += frames; }

  SessionTable& sessions() { return sessions_; }

  CaptureClocks& capture_clocks() { return capture_clocks_; }

  const MapClock& clock() const { return clock_; }

  const std::shared_ptr<FrameBudget::Account>& budget_account() const { return budget_account_; }

  /// For messages of uploads that are not decoded yet.
  const std::shared_ptr<FrameBudget::Account>& read_account() const { return read_account_; }

  /// Hands a batch to the log. Errors: as `FrameQueue::Push`.
  absl::Status Enqueue(PendingBatch batch);

  /// Adds classes to the map's table. `done` is called once they are durable, or with the error:
  /// `InvalidArgument` for classes that do not fit the table, or as for frames.
  void AddClasses(std::vector<SemanticClass> classes, std::function<void(absl::Status)> done)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Frames that wait for the log, and entries that wait for integration.
  std::size_t queued_frames() const { return queue_.waiting_frames(); }

  std::size_t unintegrated_entries() const { return integrator_.waiting_entries(); }

  /// Commits without delay once the entry `target` is integrated.
  void RequestCommit(MapSequence target);

  /// Ends the map's work: refuses everything with `status`, and so do those who wait. `on_closed`
  /// is called when the last step is over, maybe before this returns; what is integrated is
  /// committed before if `commit`. Only the first call does anything. Returns at once.
  void Close(const absl::Status& status, bool commit, const std::function<void()>& on_closed)
      ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  /// Classes on their way to the log.
  struct PendingClasses {
    std::vector<SemanticClass> classes;
    std::function<void(absl::Status)> done;
  };

  // Steps on the pools.
  Strand::Next AppendStep() ABSL_LOCKS_EXCLUDED(mutex_);
  Strand::Next MapStep() ABSL_LOCKS_EXCLUDED(mutex_);
  Strand::Next OpenStep() ABSL_LOCKS_EXCLUDED(mutex_);
  Strand::Next NextTry() ABSL_LOCKS_EXCLUDED(mutex_);

  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  LogGroup TakeGroup(std::vector<PendingClasses>* classes) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteAppended(const LogGroup& group) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckClasses(const std::vector<SemanticClass>& added) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status AdoptState(const StoredState& state) ABSL_LOCKS_EXCLUDED(mutex_);
  void Publish(PublishedRevision published) ABSL_LOCKS_EXCLUDED(mutex_);
  void SetCondition(Condition condition, const absl::Status& reason) ABSL_LOCKS_EXCLUDED(mutex_);
  void StopTaking(const absl::Status& status);
  void CommitAtEnd();

  const MapKey key_;
  const MapName name_;
  const Dependencies dependencies_;
  const std::shared_ptr<FrameBudget::Account> budget_account_;
  const std::shared_ptr<FrameBudget::Account> read_account_;
  MapClock clock_;
  SessionTable sessions_;
  CaptureClocks capture_clocks_;
  CommitWaiters waiters_;
  FrameQueue queue_;
  MapIntegrator integrator_;
  std::atomic<std::uint64_t> durable_head_ = 0;
  std::atomic<std::uint64_t> refused_frames_ = 0;
  std::chrono::milliseconds retry_delay_{0};  ///< Of the step that opens: until the next try.
  std::shared_ptr<Strand> append_strand_;     ///< Set once, in `Open`.
  std::shared_ptr<Strand> map_strand_;        ///< Likewise.

  mutable absl::Mutex mutex_;
  MapRecord record_ ABSL_GUARDED_BY(mutex_);
  Health health_ ABSL_GUARDED_BY(mutex_);
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::function<void()>> when_opened_ ABSL_GUARDED_BY(mutex_);
  PublishedRevision published_ ABSL_GUARDED_BY(mutex_);
  std::vector<SemanticClass> durable_classes_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<const KnownLabels> labels_ ABSL_GUARDED_BY(mutex_);
  std::vector<PendingClasses> pending_classes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
