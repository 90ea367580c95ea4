#pragma once

#include <atomic>
#include <chrono>

namespace steadymap {

/// When a long-lived thread last showed that it goes on; what the watchdog looks at. Thread-safe.
class Heartbeat {
 public:
  using Clock = std::chrono::steady_clock;

  /// A thread that waits for work beats at least this often.
  static constexpr std::chrono::milliseconds kMaxInterval{1000};

  void Beat() { last_.store(Clock::now()); }

  Clock::time_point last() const { return last_.load(); }

 private:
  std::atomic<Clock::time_point> last_{Clock::now()};
};

}  // namespace steadymap
