#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// Serialises writers. It never blocks a reader, so it may be held during disk syncs, unlike a
/// mutex that guards state. Thread-safe.
class WriterMutex {
 public:
  /// Holds the mutex from construction to destruction.
  class Lock {
   public:
    /// Blocks until no other writer holds the mutex.
    explicit Lock(WriterMutex* mutex) : mutex_(mutex) {
      const absl::MutexLock lock(&mutex_->mutex_,
                                 absl::Condition(
                                     +[](bool* is_held) { return !*is_held; }, &mutex_->is_held_));
      mutex_->is_held_ = true;
    }

    ~Lock() {
      const absl::MutexLock lock(&mutex_->mutex_);
      mutex_->is_held_ = false;
    }

    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

   private:
    WriterMutex* const mutex_;
  };

 private:
  absl::Mutex mutex_;
  bool is_held_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace steadymap
