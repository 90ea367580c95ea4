#pragma once

#include <chrono>
#include <optional>

namespace steadymap {

/// Tells systemd (Type=notify) how the daemon fares. Without systemd every call does nothing.
///
/// One thread.
class ServiceManagerNotifier {
 public:
  /// Reads what systemd asked for from the environment.
  ServiceManagerNotifier();

  /// The daemon serves.
  void Ready();

  /// The configuration is being read anew; followed by `Ready`.
  void Reloading();

  /// The daemon is about to end.
  void Stopping();

  /// The daemon makes progress. Must come at least once in every `watchdog_interval`.
  void FeedWatchdog();

  /// How long systemd waits for `FeedWatchdog` before it kills the daemon; none if it does not.
  std::optional<std::chrono::microseconds> watchdog_interval() const { return watchdog_interval_; }

 private:
  std::optional<std::chrono::microseconds> watchdog_interval_;
};

}  // namespace steadymap
