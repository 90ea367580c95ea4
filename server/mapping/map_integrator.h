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

/// A revision as everybody may see it: it is stored.
struct PublishedRevision {
  std::shared_ptr<const MapSnapshot> snapshot = std::make_shared<const MapSnapshot>();
  CommitMark commit;
  MapCounts counts;
};

/// The one writer of a map: integrates durable entries in the order of their sequence numbers, and
/// from time to time commits: first to the store, then, when that is synced, to everybody. Entries
/// that are in the log but not in the map when it starts come first.
///
/// A commit happens after `CommitOptions::max_frames` entries, `max_delay` after its first entry,
/// or as soon as a `RequestCommit` can be met. If one fails for want of disk space, it is tried
/// again; if it fails otherwise, the work ends: nothing that is not stored is ever shown.
///
/// An entry that ended the process while it was integrated, twice in a row, is not integrated
/// again.
///
/// `Step`, `Start`, `Count` and `CommitNow` are for one thread at a time, the others for any.
class MapIntegrator {
 public:
  using Clock = Strand::Clock;

  /// Called from `Step`, without locks held.
  using OnCommit = std::function<void(PublishedRevision)>;

  /// How a step ended.
  struct StepResult {
    absl::Status status;  ///< Not OK: no step can follow but after another `Start`.
    Strand::Next next;
  };

  /// `store` and `clock` must outlive it.
  MapIntegrator(Store* store,
                const MapClock* clock,
                const CommitOptions& options,
                OnCommit on_commit);

  /// Begins, or begins anew, from a stored state of the map of `record`. Errors: those of a
  /// configuration that is not valid, which no record holds.
  absl::Status Start(const MapRecord& record, const StoredState& state);

  /// Counts a revision of the map, what the mapper keeps in memory beside it included.
  MapCounts Count(const MapSnapshot& snapshot);

  /// Integrates for some milliseconds, or commits. An exception becomes `Internal`.
  StepResult Step();

  /// Commits what is integrated.
  absl::Status CommitNow();

  /// Appends entries; their sequence numbers follow the log's head. Bounded by the budget of which
  /// each frame holds a part.
  void Push(std::vector<DurableEntry> entries) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Commits without delay once the entry `target` is integrated.
  void RequestCommit(MapSequence target) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Drops the entries that wait; they are in the log.
  void DropWaiting() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Makes a step that is under way end after the entry at hand.
  void Interrupt() { interrupted_ = true; }

  /// Changes `CommitOptions::max_delay` for revisions that begin from now on.
  void SetMaxDelay(std::chrono::milliseconds max_delay) { max_delay_ms_ = max_delay.count(); }

  /// Entries that wait for integration, those of the log at the start not included.
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

  // Of whoever steps.
  MapRecord record_;
  std::unique_ptr<Mapper> mapper_;
  std::shared_ptr<IntegrationNote> note_;
  std::unique_ptr<KnownLabels> labels_;               ///< Of the frames in the log.
  MapSequence log_head_;                              ///< Entries up to it are read from the log.
  std::deque<LogEntry> read_ahead_;                   ///< Of the log.
  std::deque<absl::StatusOr<DurableEntry>> decoded_;  ///< Those before them.
  CommitDetails details_;                             ///< Of the commit that is being gathered.
  std::optional<MapCommit> unstored_;                 ///< Made, but the disk had no room for it.
  Clock::time_point retry_at_ = Clock::time_point::min();  ///< When to store it.
  Clock::time_point commit_due_ = Clock::time_point::max();
  Clock::time_point rest_at_ = Clock::time_point::max();  ///< When the mapper may rest.
  MapCounter counter_;

  std::atomic<bool> interrupted_ = false;
  std::atomic<std::chrono::milliseconds::rep> max_delay_ms_;
  mutable absl::Mutex mutex_;
  std::deque<DurableEntry> inbox_ ABSL_GUARDED_BY(mutex_);
  MapSequence requested_ ABSL_GUARDED_BY(mutex_);  ///< Commit at once when integrated.
};

}  // namespace steadymap
