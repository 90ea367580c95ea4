#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "server/process/worker_pool.h"

namespace steadymap {

/// A sequence of steps on a thread pool, never two at the same time. After each step other tasks of
/// the pool get a thread, so a pool of few threads serves many strands fairly.
///
/// Thread-safe. The pool must outlive the strand.
class Strand : public std::enable_shared_from_this<Strand> {
 public:
  using Clock = WorkerPool::Clock;

  /// Time of the next step if `Wake` is not called: now, at a time, or never.
  struct Next {
    std::optional<Clock::time_point> at;

    static Next Now() { return {Clock::time_point::min()}; }

    static Next At(Clock::time_point time) { return {time}; }

    static Next Never() { return {}; }
  };

  /// Makes a strand that runs `step` on `pool`. `step` must not throw. It is destroyed, with
  /// everything it owns, after its last run.
  static std::shared_ptr<Strand> Make(WorkerPool* pool, std::function<Next()> step);

  /// Used only by `Make`.
  Strand(WorkerPool* pool, std::function<Next()> step);

  /// Ensures that a step begins after this call.
  void Wake() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Stops the strand: no further step begins. Calls `on_stopped` once no step is running: from the
  /// pool after the running step if there is one, otherwise during this call. Only the first call
  /// has an effect.
  void Stop(std::function<void()> on_stopped) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  enum class State { kIdle, kScheduled, kRunning };

  void Schedule();
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void WakeAt(Clock::time_point time) ABSL_LOCKS_EXCLUDED(mutex_);
  void End(const std::function<void()>& on_stopped);

  WorkerPool* const pool_;
  std::function<Next()> step_;  ///< Used only by the thread that runs a step or ends the strand.
  absl::Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_) = State::kIdle;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;  ///< Set by `Wake` during a step.
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::function<void()> on_stopped_ ABSL_GUARDED_BY(mutex_);  ///< Called after the step.
  /// Earliest time at which the pool will wake the strand; none if no wake-up is scheduled.
  std::optional<Clock::time_point> wake_at_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
