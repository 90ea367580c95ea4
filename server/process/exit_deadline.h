#pragma once

#include <chrono>
#include <thread>

#include <absl/synchronization/notification.h>

namespace steadymap {

/// A deadline for the shutdown. If the object still exists after the timeout, logs a line and ends
/// the process with exit code 1. Loses no durable data: acknowledged frames are on disk, and
/// clients send the others again.
class ExitDeadline {
 public:
  explicit ExitDeadline(std::chrono::milliseconds timeout);

  /// Cancels the deadline.
  ~ExitDeadline();
  ExitDeadline(const ExitDeadline&) = delete;
  ExitDeadline& operator=(const ExitDeadline&) = delete;

 private:
  absl::Notification cancelled_;
  std::thread thread_;
};

}  // namespace steadymap
