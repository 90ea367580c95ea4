#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include <absl/status/status.h>

namespace steadymap {

/// Whether the result of some work is still wanted: that of a call not once its client has gone or
/// its deadline is over. What takes long asks now and then, and stops. Copies share the answer.
/// Thread-safe.
class Cancellation {
 public:
  Cancellation() : Cancellation(nullptr) {}

  /// Cancelled once `check`, which is thread-safe, says so as well; it is asked each time.
  explicit Cancellation(std::function<bool()> check)
      : state_(std::make_shared<State>(std::move(check))) {}

  void Cancel() const { state_->cancelled = true; }

  bool IsCancelled() const {
    return state_->cancelled.load(std::memory_order_relaxed) || (state_->check && state_->check());
  }

  /// OK, or `Cancelled`.
  absl::Status Check() const {
    return IsCancelled() ? absl::CancelledError("the answer is no longer wanted")
                         : absl::OkStatus();
  }

 private:
  struct State {
    explicit State(std::function<bool()> asked) : check(std::move(asked)) {}

    std::atomic<bool> cancelled = false;
    const std::function<bool()> check;
  };

  std::shared_ptr<State> state_;
};

}  // namespace steadymap
