#include "core/types/query_work.h"

#include <algorithm>

#include <absl/strings/str_cat.h>

namespace steadymap {

bool QueryWork::Check() {
  if (!status_.ok()) return false;
  if (steps_ > max_steps_) {
    status_ = absl::ResourceExhaustedError(
        absl::StrCat("the query exceeds the limit of ", max_steps_, " steps"));
  } else {
    status_ = cancellation_.Check();
  }
  const std::uint64_t left = std::max(max_steps_, steps_) - steps_;
  // The next check happens at the latest at the first step beyond the limit.
  next_check_ = steps_ + std::min(kStepsPerCheck - 1, left) + 1;
  return status_.ok();
}

}  // namespace steadymap
