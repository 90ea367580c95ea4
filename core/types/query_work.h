#pragma once

#include <cstdint>
#include <limits>
#include <utility>

#include <absl/status/status.h>

#include "core/types/cancellation.h"

namespace steadymap {

/// Counts the steps of a query and ends it: once its answer is no longer wanted, or once it has
/// taken more steps than it may. A step is one look at a voxel, an object, or a block of cells: 0.3
/// us in the mean. The same query of the same map takes the same steps everywhere. One thread.
class QueryWork {
 public:
  /// Steps between two questions whether the answer is still wanted: 0.3 ms in the mean.
  static constexpr std::uint64_t kStepsPerCheck = 1024;

  /// Work of any length whose answer is always wanted.
  QueryWork() : QueryWork(Cancellation(), std::numeric_limits<std::uint64_t>::max()) {}

  /// Work of at most `max_steps`, wanted until `cancellation` says otherwise.
  QueryWork(Cancellation cancellation, std::uint64_t max_steps)
      : cancellation_(std::move(cancellation)), max_steps_(max_steps) {}

  /// Counts `count` steps that come next; false once there must be none, then and ever after.
  bool Take(std::uint64_t count = 1) {
    steps_ += count;
    return steps_ < next_check_ ? status_.ok() : Check();
  }

  /// OK, or why the work ended: `Cancelled`, or `ResourceExhausted` after too many steps.
  const absl::Status& status() const { return status_; }

  /// Steps so far.
  std::uint64_t steps() const { return steps_; }

 private:
  bool Check();

  Cancellation cancellation_;
  std::uint64_t max_steps_;
  std::uint64_t steps_ = 0;
  std::uint64_t next_check_ = 0;  ///< In steps; the first one asks at once.
  absl::Status status_;
};

}  // namespace steadymap
