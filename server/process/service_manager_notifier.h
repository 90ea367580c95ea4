#pragma once

#include <chrono>
#include <optional>

namespace steadymap {

/// Reports the state of the daemon to systemd (Type=notify). Without systemd no call has an effect.
///
/// Must be used from one thread only.
class ServiceManagerNotifier {
 public:
  /// Reads the watchdog interval from the environment variables of systemd.
  ServiceManagerNotifier();

  /// Reports that the daemon is serving.
  void Ready();

  /// Reports that the configuration is being reloaded. `Ready` must follow.
  void Reloading();

  /// Reports that the shutdown begins.
  void Stopping();

  /// Reports progress. Must be called at least once per `watchdog_interval`.
  void FeedWatchdog();

  /// Returns the time without `FeedWatchdog` after which systemd kills the daemon; none if systemd
  /// has no watchdog for it.
  std::optional<std::chrono::microseconds> watchdog_interval() const { return watchdog_interval_; }

 private:
  std::optional<std::chrono::microseconds> watchdog_interval_;
};

}  // namespace steadymap
