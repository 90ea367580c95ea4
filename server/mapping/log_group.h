#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <vector>

#include <absl/status/status.h>

#include "core/frame/frame.h"
#include "server/mapping/commit_waiters.h"
#include "server/mapping/pending_batch.h"
#include "server/mapping/session_table.h"
#include "server/process/frame_budget.h"
#include "server/store/model/store.h"

namespace steadymap {

/// A durable log entry that waits for integration.
struct DurableEntry {
  MapSequence sequence;
  LogEntryKind kind = LogEntryKind::kFrame;
  Frame frame;  ///< Of `kSessionEnd` only the source.
  std::vector<SemanticClass> classes;
  FrameBudget::Reservation reservation;
};

/// A group of entries that is appended to a map's log in one write. Assigns a sequence number to
/// each new frame of the added batches, drops known frames so that no frame is integrated twice,
/// and reports the result to the uploads.
class LogGroup {
 public:
  /// Makes an empty group after the log's `head`. `sessions` must outlive it.
  LogGroup(MapKey map, MapSequence head, const SessionTable* sessions, MapUptime uptime);

  /// Adds an entry with new semantic classes.
  void AddClasses(std::vector<SemanticClass> classes);

  /// Adds the new frames of a batch, or refuses the whole batch.
  void AddBatch(PendingBatch batch);

  /// Completes the group. Nothing may be added afterwards.
  void Seal();

  bool empty() const { return batches_.empty() && append_.entries.empty(); }

  /// Returns the data to write; valid after `Seal`. Omits sessions without an accepted frame: their
  /// frames would be refused again after a restart, and invented sessions cannot fill the disk.
  const LogAppend& append() const { return append_; }

  /// Returns the head of the log after the write.
  MapSequence head() const { return head_; }

  /// Returns the state of the sessions after the write.
  const std::map<SessionName, SessionRecord>& sessions() const { return sessions_; }

  /// Reports to the uploads that their batches are durable, or the error.
  void Report(const absl::Status& status) const;

  /// Returns the entries for integration; call after the write has succeeded.
  std::vector<DurableEntry> TakeEntries() { return std::move(entries_); }

  /// Adds the uploads of durable batches to `waiters`.
  void AwaitCommit(CommitWaiters* waiters);

 private:
  /// A batch with the result of its check.
  struct StagedBatch {
    PendingBatch batch;
    BatchProgress progress;
    absl::Status status;  ///< Not OK: the whole batch was refused.
  };

  void AddSessionEnd(const SensorName& sensor);
  static absl::Status Settle(const PendingBatch& batch, SessionRecord* session);

  const SessionTable* const known_;
  const MapUptime uptime_;
  const Timestamp time_;
  MapSequence head_;
  std::vector<StagedBatch> batches_;
  std::map<SessionName, SessionRecord> sessions_;  ///< Sessions after the write.
  std::vector<DurableEntry> entries_;              ///< New entries, with sequence numbers.
  LogAppend append_;
};

}  // namespace steadymap
