#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "server/mapping/pending_batch.h"

namespace steadymap {

/// Uploads that wait for a revision that contains their frames. Thread-safe.
class CommitWaiters {
 public:
  CommitWaiters() = default;

  /// Calls `observer->OnIntegrated` once a revision of the map contains `progress.map_seq`,
  /// possibly before this call returns; or `OnFailed` if no revision will contain it.
  void Add(std::shared_ptr<UploadObserver> observer, const BatchProgress& progress)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// Reports a new revision, which contains the entries up to `integrated`.
  void Notify(Revision revision, MapSequence integrated) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Reports that no revision follows until `Restart`. All current and later waiters fail with
  /// `status`.
  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void Restart() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the number of waiting batch parts.
  std::size_t size() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Waiter {
    std::shared_ptr<UploadObserver> observer;
    BatchProgress progress;
  };

  mutable absl::Mutex mutex_;
  Revision revision_ ABSL_GUARDED_BY(mutex_);
  MapSequence integrated_ ABSL_GUARDED_BY(mutex_);
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
  std::multimap<MapSequence, Waiter> waiters_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
