#pragma once

#include <cstddef>

#include <absl/functional/function_ref.h>

/// Parallel loops on all cores, by oneTBB. Results must not depend on the number of threads: a
/// range writes only its own elements, and every step that depends on an order runs afterwards on
/// the calling thread.
namespace steadymap {

/// Calls `work(begin, end)` for disjoint ranges that cover [0, `count`), on the calling thread and
/// on idle helper threads. Each range has at least `min_range` elements if that many remain.
/// Returns when all ranges are done. If `count` is at most `min_range`, all elements run on the
/// calling thread. A hand-over takes some microseconds, so a range should take at least ten times
/// as long.
///
/// Rethrows exceptions of `work`. `work` must not wait for another thread, and the caller must hold
/// no mutex that `work` acquires. Any thread; calls may be nested.
void ParallelFor(std::size_t count,
                 std::size_t min_range,
                 absl::FunctionRef<void(std::size_t begin, std::size_t end)> work);

/// Sets a function that runs once on every helper thread before its first work, for example to name
/// the thread. Call before the first `ParallelFor`.
void SetHelperThreadHook(void (*hook)());

/// Returns the owner of the current thread's work, null if there is none, for reports of a crash
/// handler. `ParallelFor` passes it on to the helper threads. Async-signal-safe.
void* WorkOwner();

/// Sets the owner of all further work of the current thread; null for none.
void SetWorkOwner(void* owner);

}  // namespace steadymap
