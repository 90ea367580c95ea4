#include "core/parallel.h"

#include <algorithm>

#include <pthread.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_scheduler_observer.h>

namespace steadymap {
namespace {

thread_local void* work_owner = nullptr;

/// Names oneTBB's threads as they come to help the thread that made this.
class HelperNames final : public tbb::task_scheduler_observer {
 public:
  HelperNames() { observe(true); }

  ~HelperNames() override { observe(false); }

  HelperNames(const HelperNames&) = delete;
  HelperNames& operator=(const HelperNames&) = delete;

  void on_scheduler_entry(bool is_helper) override {
    thread_local bool is_named = false;
    if (!is_helper || is_named) return;
    ::pthread_setname_np(::pthread_self(), "compute");
    is_named = true;
  }
};

/// Works for somebody else for a while.
class BorrowedThread {
 public:
  explicit BorrowedThread(void* owner) : before_(work_owner) { work_owner = owner; }

  ~BorrowedThread() { work_owner = before_; }

  BorrowedThread(const BorrowedThread&) = delete;
  BorrowedThread& operator=(const BorrowedThread&) = delete;

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
  thread_local HelperNames helper_names;
  void* const owner = work_owner;
  // oneTBB halves what is longer than its grain, so halves are at least half as long as that.
  const std::size_t grain = std::max<std::size_t>(2 * min_range, 2) - 1;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const auto& range) {
    const BorrowedThread borrowed(owner);
    work(range.begin(), range.end());
  });
}

void* WorkOwner() { return work_owner; }

void SetWorkOwner(void* owner) { work_owner = owner; }

}  // namespace steadymap
