#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace steadymap::testing {

/// Runs `work` with at most `threads` threads of TBB, even on a machine with fewer cores.
template <typename Work>
auto RunOnThreads(int threads, const Work& work) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  return tbb::task_arena(threads).execute(work);
}

}  // namespace steadymap::testing
