#pragma once

#include <atomic>
#include <chrono>

namespace steadymap {

/// The time of the last progress of a long-lived thread. The watchdog reads it. Thread-safe.
class Heartbeat {
 public:
  using Clock = std::chrono::steady_clock;

  /// Maximum interval between beats of a thread that waits for work.
  static constexpr std::chrono::milliseconds kMaxInterval{1000};

  void Beat() { last_.store(Clock::now()); }

  Clock::time_point last() const { return last_.load(); }

 private:
  std::atomic<Clock::time_point> last_{Clock::now()};
};

}  // namespace steadymap
