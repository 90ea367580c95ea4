#include "server/mapping/frame_queue.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"

namespace steadymap {

absl::Status FrameQueue::Push(PendingBatch batch) {
  const absl::MutexLock lock(&mutex_);
  if (!closed_.ok()) return closed_;
  const std::size_t count = CountOf(batch);
  if (waiting_frames_ > 0 && waiting_frames_ + count > max_frames_) {
    return MakeError(
        absl::StatusCode::kResourceExhausted,
        reason::kQueueFull,
        absl::StrCat("the map's queue is full: ", waiting_frames_, " frames wait for the log"));
  }
  waiting_frames_ += count;
  std::deque<PendingBatch>& queue = batches_[batch.session.sensor.robot];
  queue.push_back(std::move(batch));
  return absl::OkStatus();
}

std::vector<PendingBatch> FrameQueue::PopFair(std::size_t max_frames, std::size_t max_bytes) {
  std::vector<PendingBatch> taken;
  const absl::MutexLock lock(&mutex_);
  std::size_t frames = 0;
  std::size_t bytes = 0;
  while (!batches_.empty() && frames < max_frames && bytes < max_bytes) {
    taken.push_back(PopNext());
    frames += CountOf(taken.back());
    for (const PendingFrame& frame : taken.back().frames) bytes += frame.packed.size();
  }
  return taken;
}

std::vector<PendingBatch> FrameQueue::Close(const absl::Status& status) {
  std::vector<PendingBatch> left;
  const absl::MutexLock lock(&mutex_);
  closed_ = status;
  while (!batches_.empty()) left.push_back(PopNext());
  return left;
}

void FrameQueue::Open() {
  const absl::MutexLock lock(&mutex_);
  closed_ = absl::OkStatus();
}

std::size_t FrameQueue::waiting_frames() const {
  const absl::MutexLock lock(&mutex_);
  return waiting_frames_;
}

std::size_t FrameQueue::CountOf(const PendingBatch& batch) {
  return std::max<std::size_t>(1, batch.frames.size());
}

PendingBatch FrameQueue::PopNext() {
  auto robot = batches_.upper_bound(last_robot_);
  if (robot == batches_.end()) robot = batches_.begin();
  last_robot_ = robot->first;
  PendingBatch batch = std::move(robot->second.front());
  robot->second.pop_front();
  if (robot->second.empty()) batches_.erase(robot);
  waiting_frames_ -= CountOf(batch);
  return batch;
}

}  // namespace steadymap
