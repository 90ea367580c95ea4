#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include "server/process/worker_pool.h"

namespace steadymap {

/// Does one thing's work on a pool of threads, step by step, never two steps at once. Between steps
/// others get their turn, so that a pool of few threads serves many strands fairly.
///
/// Thread-safe. Outlived by the pool.
class Strand : public std::enable_shared_from_this<Strand> {
 public:
  using Clock = WorkerPool::Clock;

  /// When the next step is wanted without anybody's waking: now, at a time, or never.
  struct Next {
    std::optional<Clock::time_point> at;

    static Next Now() { return {Clock::time_point::min()}; }

    static Next At(Clock::time_point time) { return {time}; }

    static Next Never() { return {}; }
  };

  /// `step` is run on `pool`, and throws nothing. It is destroyed, with all it holds, after the
  /// last one.
  static std::shared_ptr<Strand> Make(WorkerPool* pool, std::function<Next()> step);

  /// Use `Make`.
  Strand(WorkerPool* pool, std::function<Next()> step);

  /// Sees to it that a step begins after this call.
  void Wake() ABSL_LOCKS_EXCLUDED(mutex_);

  /// Ends the strand: no step begins any more. `on_stopped` is called once none is under way, maybe
  /// before this returns, else from the pool; where the pool has stopped, by this call. Only the
  /// first call does anything.
  void Stop(std::function<void()> on_stopped) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  enum class State { kIdle, kScheduled, kRunning };

  void Schedule();
  void Run() ABSL_LOCKS_EXCLUDED(mutex_);
  void WakeAt(Clock::time_point time) ABSL_LOCKS_EXCLUDED(mutex_);
  void End(const std::function<void()>& on_stopped);

  WorkerPool* const pool_;
  std::function<Next()> step_;  ///< Of whoever runs a step, or ends the strand.
  absl::Mutex mutex_;
  State state_ ABSL_GUARDED_BY(mutex_) = State::kIdle;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;  ///< While a step was running.
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::function<void()> on_stopped_ ABSL_GUARDED_BY(mutex_);  ///< To be called after the step.
  /// The earliest time that the pool will wake the strand at; none if it will not.
  std::optional<Clock::time_point> wake_at_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace steadymap
