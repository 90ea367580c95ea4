#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "server/config/server_config.h"

namespace steadymap {

/// The current limits; a reload of the configuration changes them. Thread-safe.
class LiveLimits {
 public:
  explicit LiveLimits(const LimitOptions& limits) : limits_(limits) {}

  LimitOptions Get() const ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    return limits_;
  }

  void Set(const LimitOptions& limits) ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    limits_ = limits;
  }

 private:
  mutable absl::Mutex mutex_;
  LimitOptions limits_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
