#pragma once

#include <atomic>
#include <chrono>

#include "server/store/model/store.h"

namespace steadymap {

/// Tells the uptime of one map. Thread-safe.
class MapClock {
 public:
  MapUptime Now() const {
    const auto running = std::chrono::steady_clock::now() - started_;
    return MapUptime(before_ns_.load()) +
           std::chrono::duration_cast<std::chrono::nanoseconds>(running);
  }

  /// The map had been open for `uptime` when it was opened last. The clock never goes back.
  void Continue(MapUptime uptime) {
    if (uptime.count() > before_ns_.load()) before_ns_ = uptime.count();
  }

 private:
  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::atomic<MapUptime::rep> before_ns_ = 0;
};

}  // namespace steadymap
