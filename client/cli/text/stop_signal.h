#pragma once

#include <chrono>
#include <optional>

namespace steadymap {

/// Handles stop signals for commands that run until they are stopped: while an instance exists,
/// SIGINT and SIGTERM end `Wait` instead of the process. At most one instance per process
/// (asserted).
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();

  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// Ends the current wait, or the next one if there is none. Any thread.
  void Notify();

  /// Waits for a signal or a `Notify`, at most for `timeout`. One thread.
  void Wait(std::optional<std::chrono::milliseconds> timeout = std::nullopt);

  /// True if a signal was received.
  bool came() const;
};

}  // namespace steadymap
