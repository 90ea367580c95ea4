#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "server/mapping/pending_batch.h"

namespace steadymap {

/// The frames of one map that wait for the log, fair between robots: they take turns, batch by
/// batch, and a robot's own batches keep their order, whatever sensors they are of.
///
/// Bounded in frames here, and in bytes by the budget that each frame holds a part of. Thread-safe.
class FrameQueue {
 public:
  /// At most `max_frames` wait; a batch without frames counts as one.
  explicit FrameQueue(std::size_t max_frames) : max_frames_(max_frames) {}

  /// Appends. Errors: `ResourceExhausted` with reason `QUEUE_FULL`, or what the queue was closed
  /// with; the batch is then dropped.
  absl::Status Push(PendingBatch batch) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes batches in turn until they hold `max_frames` frames or `max_bytes` packed bytes, or
  /// there are no more; at least one if any waits.
  std::vector<PendingBatch> PopFair(std::size_t max_frames, std::size_t max_bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Refuses from now on until `Open`, with `status`, and gives back what waited.
  std::vector<PendingBatch> Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void Open() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Frames that wait.
  std::size_t waiting_frames() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  static std::size_t CountOf(const PendingBatch& batch);
  PendingBatch PopNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::size_t max_frames_;
  mutable absl::Mutex mutex_;
  /// By robot; a robot without batches is not listed.
  std::map<std::string, std::deque<PendingBatch>> batches_ ABSL_GUARDED_BY(mutex_);
  /// The robot that was served last; the one behind it is next.
  std::string last_robot_ ABSL_GUARDED_BY(mutex_);
  std::size_t waiting_frames_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
