#pragma once

#include <cstddef>

#include <absl/functional/function_ref.h>

/// Runs the work of one call on all cores, by oneTBB. Results must not depend on the number of
/// threads: a range writes only its own elements, and the caller does everything that depends on an
/// order afterwards.
namespace steadymap {

/// Calls `work(begin, end)` for ranges that together are [0, `count`), each at least `min_range`
/// long if that many remain, on the calling thread and on idle helper threads. Returns when all
/// ranges are done. The caller does `min_range` items or fewer alone: a hand-over takes some
/// microseconds, so a range should be worth at least ten times that.
///
/// Exceptions of `work` come out of it. `work` must not wait for another thread, and the caller
/// must hold no lock that `work` takes. Any thread, nested, too.
void ParallelFor(std::size_t count,
                 std::size_t min_range,
                 absl::FunctionRef<void(std::size_t begin, std::size_t end)> work);

/// Calls `hook` once on every helper thread before its first work, for example to name the thread.
/// Call this before the first `ParallelFor`.
void SetHelperThreadHook(void (*hook)());

/// The owner of the work that the current thread does, for a crash handler to name; null if it has
/// none. `ParallelFor` passes it on to the helper threads. Safe to call in a signal handler.
void* WorkOwner();

/// Sets the owner of all further work of the current thread; null for none.
void SetWorkOwner(void* owner);

}  // namespace steadymap
