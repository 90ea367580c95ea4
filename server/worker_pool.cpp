#include "server/worker_pool.h"

#include <exception>
#include <utility>

#include <spdlog/spdlog.h>

namespace steadymap {

WorkerPool::WorkerPool(std::string name, std::size_t thread_count, std::size_t max_waiting)
    : name_(std::move(name)), max_waiting_(max_waiting) {
  threads_.reserve(thread_count);
  for (std::size_t i = 0; i < thread_count; ++i) threads_.emplace_back([this] { RunThread(); });
}

WorkerPool::~WorkerPool() { Stop(); }

bool WorkerPool::TrySubmit(std::function<void()> task) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_ || tasks_.size() >= max_waiting_) return false;
  tasks_.push_back(std::move(task));
  return true;
}

bool WorkerPool::Resume(std::function<void()> task) {
  const absl::MutexLock lock(&mutex_);
  if (stopping_) return false;
  tasks_.push_back(std::move(task));
  return true;
}

std::size_t WorkerPool::waiting() const {
  const absl::MutexLock lock(&mutex_);
  return tasks_.size();
}

void WorkerPool::Stop() {
  {
    const absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void WorkerPool::RunThread() {
  while (true) {
    std::function<void()> task;
    {
      const absl::MutexLock lock(&mutex_, absl::Condition(this, &WorkerPool::HasWork));
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    try {
      task();
    } catch (const std::exception& error) {
      spdlog::error("a task of the pool '{}' failed: {}", name_, error.what());
    }
  }
}

}  // namespace steadymap
