#include "server/mapping/commit_waiters.h"

#include <utility>
#include <vector>

namespace steadymap {

void CommitWaiters::Add(std::shared_ptr<UploadObserver> observer, const BatchProgress& progress) {
  BatchProgress integrated = progress;
  absl::Status failure;
  {
    const absl::MutexLock lock(&mutex_);
    integrated.revision = revision_;
    if (progress.map_seq > integrated_) {
      if (failure_.ok()) {
        waiters_.emplace(progress.map_seq, Waiter{std::move(observer), progress});
        return;
      }
      failure = failure_;
    }
  }
  if (failure.ok()) {
    observer->OnIntegrated(integrated);
  } else {
    observer->OnFailed(failure);
  }
}

void CommitWaiters::Notify(Revision revision, MapSequence integrated) {
  std::vector<Waiter> done;
  {
    const absl::MutexLock lock(&mutex_);
    revision_ = revision;
    integrated_ = integrated;
    const auto end = waiters_.upper_bound(integrated);
    for (auto waiter = waiters_.begin(); waiter != end; ++waiter) {
      done.push_back(std::move(waiter->second));
    }
    waiters_.erase(waiters_.begin(), end);
  }
  for (Waiter& waiter : done) {
    waiter.progress.revision = revision;
    waiter.observer->OnIntegrated(waiter.progress);
  }
}

void CommitWaiters::Fail(const absl::Status& status) {
  std::multimap<MapSequence, Waiter> failed;
  {
    const absl::MutexLock lock(&mutex_);
    failure_ = status;
    failed.swap(waiters_);
  }
  for (const auto& [sequence, waiter] : failed) waiter.observer->OnFailed(status);
}

void CommitWaiters::Restart() {
  const absl::MutexLock lock(&mutex_);
  failure_ = absl::OkStatus();
}

std::size_t CommitWaiters::size() const {
  const absl::MutexLock lock(&mutex_);
  return waiters_.size();
}

}  // namespace steadymap
