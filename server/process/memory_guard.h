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

/// Bytes of memory that this process holds: its resident set, from /proc.
std::size_t ResidentBytes();

/// Bytes of memory that this process may use: the machine's, or the least of the limits that the
/// control groups around the process set. `root` is where /proc and /sys lie.
std::size_t UsableMemoryBytes(const std::filesystem::path& root = "/");

/// The bound on the memory of the whole process. What is under way has budgets of its own; this one
/// keeps what stays, the maps, from growing beyond what the machine has: while the process holds
/// more than the bound, nothing is taken that makes it hold more. It measures instead of counting,
/// so nothing is left out. Thread-safe.
class MemoryGuard {
 public:
  using Clock = std::chrono::steady_clock;

  /// `max_bytes` 0: three quarters of `UsableMemoryBytes`. `measure` says what the process holds.
  explicit MemoryGuard(std::size_t max_bytes, std::function<std::size_t()> measure = ResidentBytes);

  /// OK, or `ResourceExhausted` with reason `MEMORY_LOW` and when to try again. Measures every 100
  /// ms at most, so it costs next to nothing.
  absl::Status Check() const ABSL_LOCKS_EXCLUDED(mutex_);

  /// As the constructor's.
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
