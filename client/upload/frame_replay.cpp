#include "client/upload/frame_replay.h"

namespace steadymap {

absl::StatusOr<std::optional<v1::Frame>> FrameReplay::Next() {
  const std::lock_guard<std::mutex> lock(mutex_);
  absl::StatusOr<std::optional<v1::Frame>> frame = source_->Next();
  if (frame.ok() && frame->has_value()) pushed_.push_back(calls_);
  ++calls_;
  return frame;
}

absl::StatusOr<v1::Frame> FrameReplay::Read(std::size_t index) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return source_->Read(index);
}

absl::StatusOr<v1::Frame> FrameReplay::ReadPushed(std::uint64_t client_seq) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (client_seq < 1 || client_seq > pushed_.size()) return NoFrameAt(client_seq, pushed_.size());
  return source_->Read(pushed_[client_seq - 1]);
}

}  // namespace steadymap
