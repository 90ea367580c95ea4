#pragma once

#include <atomic>
#include <chrono>

#include "server/store/model/store.h"

namespace steadymap {

/// The uptime clock of one map: the total time for which the map was open. Thread-safe.
class MapClock {
 public:
  MapUptime Now() const {
    const auto running = std::chrono::steady_clock::now() - started_;
    return MapUptime(before_ns_.load()) +
           std::chrono::duration_cast<std::chrono::nanoseconds>(running);
  }

  /// Continues from the stored `uptime` of earlier runs. Never sets the clock back.
  void Continue(MapUptime uptime) {
    if (uptime.count() > before_ns_.load()) before_ns_ = uptime.count();
  }

 private:
  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  std::atomic<MapUptime::rep> before_ns_ = 0;
};

}  // namespace steadymap
