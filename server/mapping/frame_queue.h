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

/// The frames of one map that wait for the log. Fair between robots: batches are taken from the
/// robots in turn, and the batches of one robot keep their order, whatever their sensors.
///
/// Bounded here by the number of frames, and by the `FrameBudget` reservation of each frame in
/// bytes. Thread-safe.
class FrameQueue {
 public:
  /// At most `max_frames` frames wait; a batch without frames counts as one.
  explicit FrameQueue(std::size_t max_frames) : max_frames_(max_frames) {}

  /// Appends a batch. On an error the batch is dropped. Errors: `ResourceExhausted` with reason
  /// `QUEUE_FULL`; the status of `Close` if the queue is closed.
  absl::Status Push(PendingBatch batch) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Takes batches from the robots in turn until they contain `max_frames` frames or `max_bytes`
  /// packed bytes, or the queue is empty. Takes at least one batch if any is waiting.
  std::vector<PendingBatch> PopFair(std::size_t max_frames, std::size_t max_bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Refuses batches with `status` until `Open` is called, and returns the waiting batches.
  std::vector<PendingBatch> Close(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void Open() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the number of waiting frames.
  std::size_t waiting_frames() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  static std::size_t CountOf(const PendingBatch& batch);
  PendingBatch PopNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::size_t max_frames_;
  mutable absl::Mutex mutex_;
  /// Batches by robot; contains only robots with batches.
  std::map<std::string, std::deque<PendingBatch>> batches_ ABSL_GUARDED_BY(mutex_);
  /// The robot of the last batch taken; the next one in the order of names follows.
  std::string last_robot_ ABSL_GUARDED_BY(mutex_);
  std::size_t waiting_frames_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status closed_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
