#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include <absl/status/statusor.h>

#include "client/upload/frame_source.h"

namespace steadymap {

/// Hands out the frames of a source and knows which of them an upload has got, so that the uploader
/// can have any of them again: `UploaderOptions::read_again`. Thread-safe, as the source need not
/// be.
class FrameReplay final : public FrameSource {
 public:
  /// `source` must outlive this and have no other reader.
  explicit FrameReplay(FrameSource* source) : source_(source) {}

  std::size_t frame_count() const override { return source_->frame_count(); }

  absl::StatusOr<std::optional<v1::Frame>> Next() override;

  absl::StatusOr<v1::Frame> Read(std::size_t index) override;

  /// The frame with this client sequence, where all frames that `Next` gave were pushed.
  /// Errors: `OutOfRange` for one that it has not given; what the source says.
  absl::StatusOr<v1::Frame> ReadPushed(std::uint64_t client_seq);

 private:
  FrameSource* source_;
  std::mutex mutex_;                 ///< Guards what follows and the use of the source.
  std::size_t calls_ = 0;            ///< Of `Next`.
  std::vector<std::size_t> pushed_;  ///< The index of each frame that `Next` gave.
};

}  // namespace steadymap
