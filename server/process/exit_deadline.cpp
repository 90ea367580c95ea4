#include "server/process/exit_deadline.h"

#include <cstdlib>

#include <absl/time/time.h>
#include <spdlog/spdlog.h>

namespace steadymap {

ExitDeadline::ExitDeadline(std::chrono::milliseconds timeout)
    : thread_([this, timeout] {
        if (cancelled_.WaitForNotificationWithTimeout(absl::FromChrono(timeout))) return;
        spdlog::critical("shutdown did not finish within {} ms; exiting", timeout.count());
        std::_Exit(EXIT_FAILURE);
      }) {}

ExitDeadline::~ExitDeadline() {
  cancelled_.Notify();
  thread_.join();
}

}  // namespace steadymap
