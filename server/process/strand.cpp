#include "server/process/strand.h"

#include <utility>

namespace steadymap {

std::shared_ptr<Strand> Strand::Make(WorkerPool* pool, std::function<Next()> step) {
  return std::make_shared<Strand>(pool, std::move(step));
}

Strand::Strand(WorkerPool* pool, std::function<Next()> step)
    : pool_(pool), step_(std::move(step)) {}

void Strand::Wake() {
  {
    const absl::MutexLock lock(&mutex_);
    if (stopped_ || state_ == State::kScheduled) return;
    if (state_ == State::kRunning) {
      woken_ = true;
      return;
    }
    state_ = State::kScheduled;
  }
  Schedule();
}

void Strand::Stop(std::function<void()> on_stopped) {
  {
    const absl::MutexLock lock(&mutex_);
    if (std::exchange(stopped_, true)) return;
    if (state_ == State::kRunning) {
      on_stopped_ = std::move(on_stopped);
      return;
    }
  }
  End(on_stopped);
}

/// A stopped pool drops the step; no further step runs then.
void Strand::Schedule() {
  const bool submitted = pool_->Submit([self = shared_from_this()] { self->Run(); });
  if (submitted) return;
  const absl::MutexLock lock(&mutex_);
  state_ = State::kIdle;
}

void Strand::Run() {
  {
    const absl::MutexLock lock(&mutex_);
    if (stopped_) return;
    state_ = State::kRunning;
    woken_ = false;
  }
  const Next next = step_();
  bool ends = false;
  bool goes_on = false;
  std::function<void()> on_stopped;
  {
    const absl::MutexLock lock(&mutex_);
    ends = stopped_;
    goes_on = woken_ || (next.at && *next.at <= Clock::now());
    state_ = !ends && goes_on ? State::kScheduled : State::kIdle;
    on_stopped = std::move(on_stopped_);
  }
  if (ends) return End(on_stopped);
  if (goes_on) return Schedule();
  if (next.at) WakeAt(*next.at);
}

void Strand::WakeAt(Clock::time_point time) {
  {
    const absl::MutexLock lock(&mutex_);
    if (wake_at_ && *wake_at_ <= time) return;
    wake_at_ = time;
  }
  pool_->SubmitAt(time, [weak = weak_from_this(), time] {
    const std::shared_ptr<Strand> self = weak.lock();
    if (self == nullptr) return;
    {
      const absl::MutexLock lock(&self->mutex_);
      if (self->wake_at_ == time) self->wake_at_.reset();
    }
    self->Wake();
  });
}

void Strand::End(const std::function<void()>& on_stopped) {
  // The step and everything it owns is destroyed before `on_stopped` runs.
  step_ = nullptr;
  if (on_stopped) on_stopped();
}

}  // namespace steadymap
