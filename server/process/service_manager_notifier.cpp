#include "server/process/service_manager_notifier.h"

#include <cstdint>
#include <ctime>
#include <string>

#include <systemd/sd-daemon.h>

namespace steadymap {
namespace {

// Returns the monotonic clock in microseconds, the format of MONOTONIC_USEC in RELOADING messages.
std::string MonotonicMicroseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::to_string(now.tv_sec * 1'000'000 + now.tv_nsec / 1000);
}

// Ignores errors: the daemon serves even if the service manager does not answer.
void Notify(const std::string& state) { static_cast<void>(::sd_notify(0, state.c_str())); }

}  // namespace

ServiceManagerNotifier::ServiceManagerNotifier() {
  std::uint64_t interval_us = 0;
  if (::sd_watchdog_enabled(0, &interval_us) > 0) {
    watchdog_interval_ = std::chrono::microseconds(interval_us);
  }
}

void ServiceManagerNotifier::Ready() { Notify("READY=1"); }

void ServiceManagerNotifier::Reloading() {
  Notify("RELOADING=1\nMONOTONIC_USEC=" + MonotonicMicroseconds());
}

void ServiceManagerNotifier::Stopping() { Notify("STOPPING=1"); }

void ServiceManagerNotifier::FeedWatchdog() { Notify("WATCHDOG=1"); }

}  // namespace steadymap
