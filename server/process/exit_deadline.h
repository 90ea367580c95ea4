#pragma once

#include <chrono>
#include <thread>

#include <absl/synchronization/notification.h>

namespace steadymap {

/// Ends the process with exit code 1 and a line in the log if it is still there when the time is
/// up. Nothing durable is lost by that: what was acknowledged is on disk, the rest is sent again.
class ExitDeadline {
 public:
  explicit ExitDeadline(std::chrono::milliseconds timeout);

  /// Calls the deadline off.
  ~ExitDeadline();
  ExitDeadline(const ExitDeadline&) = delete;
  ExitDeadline& operator=(const ExitDeadline&) = delete;

 private:
  absl::Notification called_off_;
  std::thread thread_;
};

}  // namespace steadymap
