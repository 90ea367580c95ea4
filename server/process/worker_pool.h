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

/// A fixed number of threads that run tasks in order of submission, with a bound on the number of
/// waiting tasks.
///
/// Tasks handle their own errors: an exception that leaves a task is logged and dropped.
/// Thread-safe.
class WorkerPool {
 public:
  using Clock = std::chrono::steady_clock;

  /// `name`, at most 12 characters, names the threads for the log, `top` and debuggers. At most
  /// `max_waiting` tasks wait for a thread. If the system can create only some of the threads, the
  /// pool runs with fewer and logs an error. Throws `std::system_error` if it can create none.
  WorkerPool(std::string name, std::size_t thread_count, std::size_t max_waiting);

  /// Stops the pool with `Stop`.
  ~WorkerPool();

  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Runs `task` when a thread is free. Returns false and drops `task` if `max_waiting` tasks are
  /// waiting or the pool has stopped.
  [[nodiscard]] bool TrySubmit(std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Runs `task` when a thread is free, even if `max_waiting` tasks are waiting; for tasks whose
  /// number is bounded elsewhere. Returns false and drops `task` if the pool has stopped.
  bool Submit(std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Submits `task` with `Submit` at `time`. Tasks that are not yet due when the pool stops are
  /// dropped.
  void SubmitAt(Clock::time_point time, std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the number of tasks that wait for a thread.
  std::size_t waiting() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Returns the start time of the task that has been running longest; none if no task is running.
  /// The watchdog reads it.
  std::optional<Clock::time_point> oldest_start() const ABSL_LOCKS_EXCLUDED(mutex_);

  const std::string& name() const { return name_; }

  /// Runs all waiting tasks, then ends the threads. Must not be called from a task.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void RunThread(std::size_t index) ABSL_LOCKS_EXCLUDED(mutex_);
  std::optional<std::function<void()>> TakeTask(std::size_t index) ABSL_LOCKS_EXCLUDED(mutex_);
  void MoveDue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !tasks_.empty() || delayed_changed_;
  }

  const std::string name_;
  const std::size_t max_waiting_;
  mutable absl::Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  std::multimap<Clock::time_point, std::function<void()>> delayed_ ABSL_GUARDED_BY(mutex_);
  bool delayed_changed_ ABSL_GUARDED_BY(mutex_) = false;  ///< Wakes a thread to read the next time.
  std::vector<std::optional<Clock::time_point>> starts_ ABSL_GUARDED_BY(mutex_);  ///< By thread.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

/// Sets the name of the calling thread, for `top` and debuggers; at most 15 characters.
void NameThread(const std::string& name);

}  // namespace steadymap
