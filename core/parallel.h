#pragma once

#include <cstddef>

#include <absl/functional/function_ref.h>

/// Work of one call on all cores, by oneTBB. Results must not depend on the number of threads: a
/// part writes only what is its own, and whatever depends on an order is done by the caller
/// afterwards.
namespace steadymap {

/// Calls `work(begin, end)` for ranges that together are [0, `count`), each at least `min_range`
/// long if that many remain, on the calling thread and on those that are free. Returns when all is
/// done. At most `min_range` items are done by the caller alone: hand-over takes some microseconds,
/// so a range should be worth at least ten times that.
///
/// Exceptions of `work` come out of it. `work` must not wait for another thread, and the caller
/// must hold no lock that `work` takes. Any thread, nested, too.
void ParallelFor(std::size_t count,
                 std::size_t min_range,
                 absl::FunctionRef<void(std::size_t begin, std::size_t end)> work);

/// Has `greet` called on every thread that comes to help, once and before it does: to name it. To
/// be called before there is work.
void SetHelperThreadHook(void (*hook)());

/// On whose behalf the current thread works, for those that look from outside, such as a handler of
/// crashes; null: on nobody's. `ParallelFor` takes it along to the threads that help. May be called
/// in a signal handler.
void* WorkOwner();

/// From now on the current thread works for `owner`.
void SetWorkOwner(void* owner);

}  // namespace steadymap
