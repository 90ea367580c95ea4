#include "server/process/worker_pool.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include <absl/time/time.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

namespace steadymap {
namespace {

constexpr std::size_t kMaxThreadName = 15;

}  // namespace

void NameThread(const std::string& name) {
  ::pthread_setname_np(::pthread_self(), name.substr(0, kMaxThreadName).c_str());
}

WorkerPool::WorkerPool(std::string name, std::size_t thread_count, std::size_t max_waiting)
    : name_(std::move(name)), max_waiting_(max_waiting), starts_(thread_count) {
  threads_.reserve(thread_count);
  try {
    while (threads_.size() < thread_count) {
      threads_.emplace_back([this, index = threads_.size()] { RunThread(index); });
    }
  } catch (const std::system_error& error) {
    spdlog::error("the thread pool '{}' has {} threads instead of {}: {}",
                  name_,
                  threads_.size(),
                  thread_count,
                  error.what());
    if (threads_.empty()) throw;
  }
}

WorkerPool::~WorkerPool() { Stop(); }

bool WorkerPool::TrySubmit(std::function<void()> task) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_ || tasks_.size() >= max_waiting_) return false;
  tasks_.push_back(std::move(task));
  return true;
}

bool WorkerPool::Submit(std::function<void()> task) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_) return false;
  tasks_.push_back(std::move(task));
  return true;
}

void WorkerPool::SubmitAt(Clock::time_point time, std::function<void()> task) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_) return;
  const auto added = delayed_.emplace(time, std::move(task));
  if (added == delayed_.begin()) delayed_changed_ = true;
}

std::size_t WorkerPool::waiting() const {
  const absl::MutexLock lock(&mutex_);
  return tasks_.size();
}

std::optional<WorkerPool::Clock::time_point> WorkerPool::oldest_start() const {
  std::optional<Clock::time_point> oldest;
  const absl::MutexLock lock(&mutex_);
  for (const std::optional<Clock::time_point>& start : starts_) {
    if (start) oldest = std::min(oldest.value_or(*start), *start);
  }
  return oldest;
}

void WorkerPool::Stop() {
  std::multimap<Clock::time_point, std::function<void()>> dropped;
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
    dropped.swap(delayed_);
  }
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void WorkerPool::RunThread(std::size_t index) {
  NameThread(name_ + "-" + std::to_string(index));
  while (std::optional<std::function<void()>> task = TakeTask(index)) {
    try {
      (*task)();
    } catch (const std::exception& error) {
      spdlog::error("a task of the thread pool '{}' failed: {}", name_, error.what());
    }
  }
}

/// Waits for the next task and returns it; none after the pool has stopped.
std::optional<std::function<void()>> WorkerPool::TakeTask(std::size_t index) {
  const absl::MutexLock lock(&mutex_);
  starts_[index].reset();
  while (true) {
    MoveDue();
    if (!tasks_.empty()) {
      std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      starts_[index] = Clock::now();
      // Another thread must wait for the next due time, because this task may run for long.
      delayed_changed_ = !delayed_.empty();
      return task;
    }
    if (stopping_) return std::nullopt;
    const absl::Duration wait = delayed_.empty()
                                    ? absl::InfiniteDuration()
                                    : absl::FromChrono(delayed_.begin()->first - Clock::now());
    mutex_.AwaitWithTimeout(absl::Condition(this, &WorkerPool::HasWork), wait);
    delayed_changed_ = false;
  }
}

void WorkerPool::MoveDue() {
  const auto end = delayed_.upper_bound(Clock::now());
  for (auto due = delayed_.begin(); due != end; ++due) tasks_.push_back(std::move(due->second));
  delayed_.erase(delayed_.begin(), end);
}

}  // namespace steadymap
