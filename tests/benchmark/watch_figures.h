#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmark/frame_feed.h"
#include "tests/benchmark/watch_crowd.h"

namespace steadymap::benchmarks {

/// Measurements of watchers during one upload.
struct WatchFigures {
  /// Longest delay of a watcher: from the first report of a revision (to the uploader or a watcher)
  /// to the progress that completes it at the watcher. Infinite if the progress never arrived.
  double most_behind_s = 0.0;

  /// Largest number of commits in one step of a watcher; 1 if all watchers kept up.
  std::uint64_t most_commits_a_step = 0;

  /// From the push of a frame to a watcher's first message of the revision that contains it; over
  /// all frames and watchers.
  double median_latency_s = 0.0;
  double p95_latency_s = 0.0;

  /// Bytes received by a watcher divided by the number of frames; mean over the watchers.
  double bytes_a_frame = 0.0;
};

/// Measures the watchers that have steps and did not stall; all zero without such watchers.
WatchFigures MeasureWatch(const FeedRecord& feed, const std::vector<WatcherRecord>& watchers);

/// Returns the quantile `share`, in [0, 1]; 0 without values.
double Quantile(std::vector<double> values, double share);

}  // namespace steadymap::benchmarks
