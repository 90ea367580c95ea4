#pragma once

#include <functional>

#include <absl/time/clock.h>
#include <absl/time/time.h>

namespace steadymap::testing {

/// Waits until `holds` is true, for at most 30 s; checks every 5 ms. Returns false after a timeout.
inline bool Eventually(const std::function<bool()>& holds) {
  const absl::Time give_up = absl::Now() + absl::Seconds(30);
  while (!holds()) {
    if (absl::Now() > give_up) return false;
    absl::SleepFor(absl::Milliseconds(5));
  }
  return true;
}

}  // namespace steadymap::testing
