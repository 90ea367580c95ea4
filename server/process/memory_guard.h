#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>

namespace steadymap {

/// Returns the resident set size of this process in bytes, from /proc.
std::size_t ResidentBytes();

/// Returns the number of bytes of memory that this process may use: the smallest of the machine's
/// memory and the limits of the control groups of the process. `root` is the folder that contains
/// /proc and /sys.
std::size_t UsableMemoryBytes(const std::filesystem::path& root = "/");

/// A limit on the memory of the whole process. In-flight frames and messages have their own
/// budgets; this limit covers the maps, which stay in memory. While the process uses more than the
/// limit, requests that need additional memory are refused. The guard measures the process instead
/// of counting allocations, so it covers all memory. Thread-safe.
class MemoryGuard {
 public:
  using Clock = std::chrono::steady_clock;

  /// `max_bytes` 0 means three quarters of `UsableMemoryBytes`. `measure` returns the memory of the
  /// process in bytes.
  explicit MemoryGuard(std::size_t max_bytes, std::function<std::size_t()> measure = ResidentBytes);

  /// Returns OK, or `ResourceExhausted` with reason `MEMORY_LOW` and a retry delay. Measures at
  /// most once per 100 ms, so its cost is negligible.
  absl::Status Check() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// Sets a new limit; 0 means three quarters of `UsableMemoryBytes`.
  void SetMax(std::size_t max_bytes);

  std::size_t max_bytes() const { return max_bytes_; }

 private:
  std::size_t Measure() const ABSL_LOCKS_EXCLUDED(mutex_);

  const std::function<std::size_t()> measure_;
  std::atomic<std::size_t> max_bytes_;
  mutable absl::Mutex mutex_;
  mutable Clock::time_point measured_ ABSL_GUARDED_BY(mutex_) = Clock::time_point::min();
  mutable std::size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace steadymap
