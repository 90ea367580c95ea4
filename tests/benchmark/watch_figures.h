#pragma once

#include <cstdint>
#include <vector>

#include "tests/benchmark/frame_feed.h"
#include "tests/benchmark/watch_crowd.h"

namespace steadymap::benchmarks {

/// How watchers fared during one upload.
struct WatchFigures {
  /// The longest that a watcher had to wait for anything: from the first that anybody heard of a
  /// revision (the uploader or a watcher) until the watcher was told that it has it. Infinite if
  /// it never was.
  double most_behind_s = 0.0;

  /// The most commits that a watcher got in one step; 1 if all kept up.
  std::uint64_t most_commits_a_step = 0;

  /// From handing a frame to the uploader until a watcher's first message of the revision that
  /// contains it; over all frames and watchers.
  double median_latency_s = 0.0;
  double p95_latency_s = 0.0;

  /// What a watcher got, over the number of frames; mean over the watchers.
  double bytes_a_frame = 0.0;
};

/// Of the watchers that have steps and did not stall; all zero if none has.
WatchFigures MeasureWatch(const FeedRecord& feed, const std::vector<WatcherRecord>& watchers);

/// The value that a `share` of the others does not exceed, in [0, 1]; 0 of none.
double Quantile(std::vector<double> values, double share);

}  // namespace steadymap::benchmarks
