#pragma once

#include <cstdint>
#include <limits>
#include <utility>

#include <absl/status/status.h>

#include "core/types/cancellation.h"

namespace steadymap {

/// Counts the steps of a query, and ends it on cancellation or beyond a maximum number of steps. A
/// step is one access to a voxel, an object, or a block of cells: 0.3 us on average. The same query
/// of the same map takes the same number of steps on every machine. One thread at a time.
class QueryWork {
 public:
  /// Steps between two checks for cancellation: 0.3 ms on average.
  static constexpr std::uint64_t kStepsPerCheck = 1024;

  /// Work without a step limit that is never cancelled.
  QueryWork() : QueryWork(Cancellation(), std::numeric_limits<std::uint64_t>::max()) {}

  /// Work of at most `max_steps` that `cancellation` ends.
  QueryWork(Cancellation cancellation, std::uint64_t max_steps)
      : cancellation_(std::move(cancellation)), max_steps_(max_steps) {}

  /// Counts the next `count` steps. Returns false if they must not be executed; from then on, every
  /// call returns false.
  bool Take(std::uint64_t count = 1) {
    steps_ += count;
    return steps_ < next_check_ ? status_.ok() : Check();
  }

  /// Returns OK, or the reason of the end: `Cancelled`, or `ResourceExhausted` after too many
  /// steps.
  const absl::Status& status() const { return status_; }

  /// Returns the number of steps counted so far.
  std::uint64_t steps() const { return steps_; }

 private:
  bool Check();

  Cancellation cancellation_;
  std::uint64_t max_steps_;
  std::uint64_t steps_ = 0;
  std::uint64_t next_check_ = 0;  ///< In steps. 0, so that the first step checks.
  absl::Status status_;
};

}  // namespace steadymap
