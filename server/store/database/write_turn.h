#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// Lets writers take turns. A turn is not a lock: nothing but other writers waits for it, so it may
/// be held while the disk syncs. Thread-safe.
class WriteTurn {
 public:
  /// A turn, held from construction to destruction.
  class Held {
   public:
    /// Waits until nobody has the turn.
    explicit Held(WriteTurn* turn) : turn_(turn) {
      const absl::MutexLock lock(&turn_->mutex_,
                                 absl::Condition(
                                     +[](bool* taken) { return !*taken; }, &turn_->taken_));
      turn_->taken_ = true;
    }

    ~Held() {
      const absl::MutexLock lock(&turn_->mutex_);
      turn_->taken_ = false;
    }

    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

   private:
    WriteTurn* const turn_;
  };

 private:
  absl::Mutex mutex_;
  bool taken_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace steadymap
