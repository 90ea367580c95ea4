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

/// A durable entry on its way into the map.
struct DurableEntry {
  MapSequence sequence;
  LogEntryKind kind = LogEntryKind::kFrame;
  Frame frame;
  std::vector<SemanticClass> classes;
  FrameBudget::Reservation reservation;
};

/// What is written to a map's log at once: finds the place of each frame of some batches, leaves
/// out what is known already, so that none counts twice however it came here, and tells the uploads
/// what became of it.
class LogGroup {
 public:
  /// A group behind the log's `head`. `sessions` outlives it.
  LogGroup(MapKey map, MapSequence head, const SessionTable* sessions, MapUptime uptime);

  /// Adds an entry that is no frame.
  void AddClasses(std::vector<SemanticClass> classes);

  /// Adds the frames of a batch that are not known yet, or refuses the batch as a whole.
  void AddBatch(PendingBatch batch);

  /// Nothing more is added.
  void Seal();

  bool empty() const { return batches_.empty() && append_.entries.empty(); }

  /// What is to be written, once the group is sealed. Sessions of which no frame was ever taken are
  /// left out: what was refused is refused again, and made-up sessions fill no disk.
  const LogAppend& append() const { return append_; }

  /// The log's head once it is written.
  MapSequence head() const { return head_; }

  /// The sessions as they are once it is written.
  const std::map<SessionName, SessionRecord>& sessions() const { return sessions_; }

  /// Tells the uploads that their batches are durable, or why they are not.
  void Report(const absl::Status& status) const;

  /// The entries for integration, once they are durable.
  std::vector<DurableEntry> TakeEntries() { return std::move(entries_); }

  /// Lets the uploads of durable batches wait for integration.
  void AwaitCommit(CommitWaiters* waiters);

 private:
  /// A batch, with what has been found out about it.
  struct StagedBatch {
    PendingBatch batch;
    BatchProgress progress;
    absl::Status status;  ///< Not OK: it was refused as a whole.
  };

  static absl::Status Settle(const PendingBatch& batch, SessionRecord* session);

  const SessionTable* const known_;
  const MapUptime uptime_;
  const Timestamp time_;
  MapSequence head_;
  std::vector<StagedBatch> batches_;
  std::map<SessionName, SessionRecord> sessions_;  ///< As they will be.
  std::vector<DurableEntry> entries_;              ///< What is new, with its place.
  LogAppend append_;
};

}  // namespace steadymap
