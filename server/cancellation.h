#pragma once

#include <atomic>
#include <memory>

#include <absl/status/status.h>

namespace steadymap {

/// Whether the answer to a call is still wanted: not once the client has gone or its deadline is
/// over. What takes long asks now and then, and stops. Copies share the answer. Thread-safe.
class Cancellation {
 public:
  Cancellation() : cancelled_(std::make_shared<std::atomic<bool>>(false)) {}

  void Cancel() const { *cancelled_ = true; }

  bool IsCancelled() const { return *cancelled_; }

  /// OK, or `Cancelled`.
  absl::Status Check() const {
    return IsCancelled() ? absl::CancelledError("the answer is no longer wanted")
                         : absl::OkStatus();
  }

 private:
  std::shared_ptr<std::atomic<bool>> cancelled_;
};

}  // namespace steadymap
