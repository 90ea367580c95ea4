#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// A fixed number of threads that run tasks in the order they come, with a bound on how many wait.
///
/// An exception that leaves a task is logged and dropped: tasks answer for their own errors.
/// Thread-safe.
class WorkerPool {
 public:
  using Clock = std::chrono::steady_clock;

  /// `name`, of at most 12 characters, names the threads for the log, `top` and debuggers. At most
  /// `max_waiting` tasks wait for a thread. Where the system makes fewer threads, the pool has
  /// fewer, and the log says so; throws `std::system_error` where it makes none.
  WorkerPool(std::string name, std::size_t thread_count, std::size_t max_waiting);

  /// Stops as `Stop` does.
  ~WorkerPool();

  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Runs `task` when a thread is free. False, and `task` is dropped, if too many wait already or
  /// the pool has stopped.
  [[nodiscard]] bool TrySubmit(std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Runs `task` when a thread is free, however many wait: for what is bounded by other means.
  /// False, and `task` is dropped, if the pool has stopped.
  bool Submit(std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Runs `task` as `Submit` does, once it is `time`. What has not run when the pool stops is
  /// dropped.
  void SubmitAt(Clock::time_point time, std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Tasks that wait for a thread.
  std::size_t waiting() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// When the task that has run for longest began; none if none runs. What a watchdog looks at.
  std::optional<Clock::time_point> oldest_start() const ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string& name() const { return name_; }

  /// Runs what waits, then ends the threads. Not from a task.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void RunThread(std::size_t index) ABSL_LOCKS_EXCLUDED(mutex_);
  std::optional<std::function<void()>> TakeTask(std::size_t index) ABSL_LOCKS_EXCLUDED(mutex_);
  void MoveDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !tasks_.empty() || later_changed_;
  }

  const std::string name_;
  const std::size_t max_waiting_;
  mutable absl::Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  std::multimap<Clock::time_point, std::function<void()>> later_ ABSL_GUARDED_BY(mutex_);
  bool later_changed_ ABSL_GUARDED_BY(mutex_) = false;  ///< A thread must look when it is next due.
  std::vector<std::optional<Clock::time_point>> starts_ ABSL_GUARDED_BY(mutex_);  ///< By thread.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

/// Names the calling thread for `top` and debuggers: at most 15 characters.
void NameThread(const std::string& name);

}  // namespace steadymap
