#pragma once

#include <cstddef>
#include <deque>
#include <functional>
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
  /// `name` is for the log. At most `max_waiting` tasks wait for a thread.
  WorkerPool(std::string name, std::size_t thread_count, std::size_t max_waiting);

  /// Stops as `Stop` does.
  ~WorkerPool();

  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Runs `task` when a thread is free. False, and `task` is dropped, if too many wait already or
  /// the pool has stopped.
  [[nodiscard]] bool TrySubmit(std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Runs `task` after those that wait, whatever their number: for work in steps that was let in
  /// before and takes turns with the others. False, and `task` is dropped, if the pool has stopped.
  [[nodiscard]] bool Resume(std::function<void()> task) ABSL_LOCKS_EXCLUDED(mutex_);

  /// Tasks that wait for a thread.
  std::size_t waiting() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Runs what waits, then ends the threads. Not from a task.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void RunThread() ABSL_LOCKS_EXCLUDED(mutex_);

  bool HasWork() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !tasks_.empty();
  }

  const std::string name_;
  const std::size_t max_waiting_;
  mutable absl::Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace steadymap
