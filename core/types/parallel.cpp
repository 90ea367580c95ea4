#include "core/types/parallel.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_scheduler_observer.h>

namespace steadymap {
namespace {

thread_local void* work_owner = nullptr;

std::atomic<void (*)()> helper_thread_hook = nullptr;

/// Calls the hook on oneTBB's worker threads when they start to help the thread that owns this
/// object.
class HelperThreadObserver final : public tbb::task_scheduler_observer {
 public:
  HelperThreadObserver() { observe(true); }

  ~HelperThreadObserver() override { observe(false); }

  HelperThreadObserver(const HelperThreadObserver&) = delete;
  HelperThreadObserver& operator=(const HelperThreadObserver&) = delete;

  void on_scheduler_entry(bool is_helper) override {
    thread_local bool is_known = false;
    if (!is_helper || std::exchange(is_known, true)) return;
    if (void (*const hook)() = helper_thread_hook) hook();
  }
};

/// Sets the work owner of the current thread for its own lifetime, then restores the previous one.
class ScopedWorkOwner {
 public:
  explicit ScopedWorkOwner(void* owner) : before_(work_owner) { work_owner = owner; }

  ~ScopedWorkOwner() { work_owner = before_; }

  ScopedWorkOwner(const ScopedWorkOwner&) = delete;
  ScopedWorkOwner& operator=(const ScopedWorkOwner&) = delete;

 private:
  void* const before_;
};

}  // namespace

void ParallelFor(std::size_t count,
                 std::size_t min_range,
                 absl::FunctionRef<void(std::size_t begin, std::size_t end)> work) {
  if (count == 0) return;
  if (count <= min_range) {
    work(0, count);
    return;
  }
  thread_local HelperThreadObserver observer;
  void* const owner = work_owner;
  // oneTBB splits ranges longer than its grain in half, so each half has at least half that length.
  const std::size_t grain = std::max<std::size_t>(2 * min_range, 2) - 1;
  // oneTBB itself orders the accesses before, within and after the loop. The flag makes this order
  // visible to ThreadSanitizer, which does not instrument the library.
  std::atomic<int> order = 0;
  order.store(1, std::memory_order_release);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    order.load(std::memory_order_acquire);
    const ScopedWorkOwner borrowed(owner);
    work(range.begin(), range.end());
    order.fetch_add(1, std::memory_order_release);
  });
  order.load(std::memory_order_acquire);
}

void SetHelperThreadHook(void (*hook)()) { helper_thread_hook = hook; }

void* WorkOwner() { return work_owner; }

void SetWorkOwner(void* owner) { work_owner = owner; }

}  // namespace steadymap
