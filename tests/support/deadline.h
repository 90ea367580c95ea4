#pragma once

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <thread>

#include <absl/synchronization/notification.h>
#include <absl/time/time.h>

namespace steadymap::testing {

/// Runs `work` and returns when it has ended. If it does not end within a minute, names `what` on
/// standard error and aborts the test program: nothing can stop a thread that hangs.
inline void RunWithDeadline(const char* what, const std::function<void()>& work) {
  absl::Notification ended;
  std::thread watchdog([&] {
    if (ended.WaitForNotificationWithTimeout(absl::Seconds(60))) return;
    std::fprintf(stderr, "%s did not end within a minute\n", what);
    std::abort();
  });
  work();
  ended.Notify();
  watchdog.join();
}

}  // namespace steadymap::testing
