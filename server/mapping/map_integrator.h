#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "core/map/map_counts.h"
#include "core/mapper.h"
#include "server/config/server_config.h"
#include "server/mapping/log_group.h"
#include "server/mapping/map_clock.h"
#include "server/process/strand.h"
#include "server/store/model/store.h"

namespace steadymap {

/// A revision that is stored and may be read by clients.
struct PublishedRevision {
  std::shared_ptr<const MapSnapshot> snapshot = std::make_shared<const MapSnapshot>();
  CommitMark commit;
  MapCounts counts;
};

/// The single writer of a map. Integrates durable entries in the order of their sequence numbers
/// and commits periodically: first to the store and, after the disk sync, to readers. At the start
/// it first replays the log entries that are not in the stored map.
///
/// A commit happens after `CommitOptions::max_frames` entries, `max_delay` after the first entry,
/// or as soon as a `RequestCommit` can be satisfied. A commit that fails for lack of disk space is
/// retried. After any other failure the integration stops, so that no unstored revision is ever
/// published.
///
/// If the process crashed twice in a row during the integration of an entry, that entry is not
/// integrated again.
///
/// `Step`, `Start`, `Count` and `CommitNow` must not be called concurrently; the other functions
/// are thread-safe.
class MapIntegrator {
 public:
  using Clock = Strand::Clock;

  /// Called from `Step` and `CommitNow`, without locks held.
  using OnCommit = std::function<void(PublishedRevision)>;

  /// The result of a step.
  struct StepResult {
    absl::Status status;  ///< If not OK, `Start` must precede the next step.
    Strand::Next next;
  };

  /// `store` and `clock` must outlive the integrator.
  MapIntegrator(Store* store,
                const MapClock* clock,
                const CommitOptions& options,
                OnCommit on_commit);

  /// Starts or restarts from a stored state of the map of `record`. Errors: those of an invalid
  /// configuration, which no stored record contains.
  absl::Status Start(const MapRecord& record, const StoredState& state);

  /// Counts the contents of a revision, including the memory that the mapper uses in addition.
  MapCounts Count(const MapSnapshot& snapshot);

  /// Integrates for some milliseconds, or commits. An exception becomes `Internal`.
  StepResult Step();

  /// Commits the integrated entries.
  absl::Status CommitNow();

  /// Appends entries, with sequence numbers that follow the head of the log. Bounded by the
  /// `FrameBudget` reservation of each frame.
  void Push(std::vector<DurableEntry> entries) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Commits without delay after the entry `target` is integrated.
  void RequestCommit(MapSequence target) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Drops the waiting entries; they remain in the log.
  void DropWaiting() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Makes the current step return after the current entry.
  void Interrupt() { interrupted_ = true; }

  /// Changes `CommitOptions::max_delay`, for later revisions.
  void SetMaxDelay(std::chrono::milliseconds max_delay) { max_delay_ms_ = max_delay.count(); }

  /// Returns the number of entries that wait for integration, without the entries of the log at the
  /// start.
  std::size_t waiting_entries() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  absl::Status Advance();
  absl::StatusOr<std::optional<DurableEntry>> TakeEntry();
  absl::Status DecodeAhead();
  absl::Status ReadAhead();
  absl::Status Integrate(const DurableEntry& entry);
  absl::Status CheckSuspect(MapSequence sequence);
  absl::Status Commit();
  Strand::Next NextStep() const ABSL_LOCKS_EXCLUDED(mutex_);
  bool IsCommitDue() const ABSL_LOCKS_EXCLUDED(mutex_);

  Store* const store_;
  const MapClock* const clock_;
  const CommitOptions options_;
  const OnCommit on_commit_;

  // Used only by the stepping thread.
  MapRecord record_;
  std::unique_ptr<Mapper> mapper_;
  std::shared_ptr<IntegrationNote> note_;
  std::unique_ptr<KnownLabels> labels_;               ///< Labels for frames of the log.
  MapSequence log_head_;                              ///< Entries up to it are read from the log.
  std::deque<LogEntry> read_ahead_;                   ///< Entries read from the log.
  std::deque<absl::StatusOr<DurableEntry>> decoded_;  ///< Entries before `read_ahead_`.
  CommitDetails details_;                             ///< Details of the next commit.
  std::optional<MapCommit> unstored_;                 ///< Commit that waits for disk space.
  Clock::time_point retry_at_ = Clock::time_point::min();  ///< When to store `unstored_`.
  Clock::time_point commit_due_ = Clock::time_point::max();
  Clock::time_point release_at_ = Clock::time_point::max();  ///< When to call `Rest`.
  MapCounter counter_;

  std::atomic<bool> interrupted_ = false;
  std::atomic<std::chrono::milliseconds::rep> max_delay_ms_;
  mutable absl::Mutex mutex_;
  std::deque<DurableEntry> inbox_ ABSL_GUARDED_BY(mutex_);
  MapSequence requested_ ABSL_GUARDED_BY(mutex_);  ///< Commit once it is integrated.
};

}  // namespace steadymap
