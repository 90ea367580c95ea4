#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include <absl/status/status.h>

namespace steadymap {

/// A flag that cancels some work, for example after the client of a call disconnects or the
/// deadline of the call expires. Long work checks it at intervals and stops. Copies share the
/// state. Thread-safe.
class Cancellation {
 public:
  Cancellation() : Cancellation(nullptr) {}

  /// Also cancelled once `check` returns true. `check` must be thread-safe; every query of the
  /// state calls it.
  explicit Cancellation(std::function<bool()> check)
      : state_(std::make_shared<State>(std::move(check))) {}

  void Cancel() const { state_->cancelled = true; }

  bool IsCancelled() const {
    return state_->cancelled.load(std::memory_order_relaxed) || (state_->check && state_->check());
  }

  /// Returns OK, or `Cancelled`.
  absl::Status Check() const {
    return IsCancelled() ? absl::CancelledError("the call was cancelled or its deadline expired")
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
