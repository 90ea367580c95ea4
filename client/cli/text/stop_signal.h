#pragma once

#include <chrono>
#include <optional>

namespace steadymap {

/// For commands that run until they are stopped: while it lives, SIGINT and SIGTERM end `Wait`
/// instead of the process. One at a time in a process (asserted).
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();

  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// Ends the wait that runs, or else the next one. Any thread.
  void Notify();

  /// Waits for a signal or a `Notify`, at most for so long. One thread.
  void Wait(std::optional<std::chrono::milliseconds> timeout = std::nullopt);

  /// Whether a signal came.
  bool came() const;
};

}  // namespace steadymap
