#pragma once

#include <chrono>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// Limits the rate of a log line that clients can trigger. Thread-safe.
class LogLimiter {
 public:
  using Clock = std::chrono::steady_clock;

  /// Allows at most `lines` per `interval`.
  LogLimiter(int lines, Clock::duration interval) : lines_(lines), interval_(interval) {}

  /// True if a line may be written at `now`. Counts that line.
  bool Allows(Clock::time_point now) ABSL_LOCKS_EXCLUDED(mutex_) {
    const absl::MutexLock lock(&mutex_);
    if (written_ == 0 || now - began_ >= interval_) {
      began_ = now;
      written_ = 0;
    }
    if (written_ >= lines_) return false;
    ++written_;
    return true;
  }

 private:
  const int lines_;
  const Clock::duration interval_;
  absl::Mutex mutex_;
  Clock::time_point began_ ABSL_GUARDED_BY(mutex_);
  int written_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace steadymap
