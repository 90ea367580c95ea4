#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

#include "server/mapping/pending_batch.h"

namespace steadymap {

/// Those who wait until a map has a revision that shows their frames. Thread-safe.
class CommitWaiters {
 public:
  CommitWaiters() = default;

  /// Calls `observer->OnIntegrated` once the map shows `progress.map_seq`, maybe before this
  /// returns; or `OnFailed` if it never will.
  void Add(std::shared_ptr<UploadObserver> observer, const BatchProgress& progress)
      ABSL_LOCKS_EXCLUDED(mutex_);

  /// The map has come to `revision`, which holds the entries up to `integrated`.
  void Notify(Revision revision, MapSequence integrated) ABSL_LOCKS_EXCLUDED(mutex_);

  /// There will be no further revision until `Restart`: everybody, now and later, gets `status`.
  void Fail(const absl::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void Restart() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Pieces that wait.
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
