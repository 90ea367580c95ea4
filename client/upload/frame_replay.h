#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include <absl/status/statusor.h>

#include "client/upload/frame_source.h"

namespace steadymap {

/// Delivers the frames of a source and records their positions, so that an uploader can read any
/// pushed frame again (`UploaderOptions::read_again`). Thread-safe, even if the source is not.
class FrameReplay final : public FrameSource {
 public:
  /// `source` must outlive this object and have no other reader.
  explicit FrameReplay(FrameSource* source) : source_(source) {}

  std::size_t frame_count() const override { return source_->frame_count(); }

  absl::StatusOr<std::optional<v1::Frame>> Next() override;

  absl::StatusOr<v1::Frame> Read(std::size_t index) override;

  /// Reads the frame with this client sequence again. Requires that every frame returned by `Next`
  /// was pushed, in order. Errors: `OutOfRange` for a frame that `Next` has not returned; errors of
  /// the source.
  absl::StatusOr<v1::Frame> ReadPushed(std::uint64_t client_seq);

 private:
  FrameSource* source_;
  std::mutex mutex_;                 ///< Guards the members below and all calls of the source.
  std::size_t calls_ = 0;            ///< Number of calls of `Next`.
  std::vector<std::size_t> pushed_;  ///< Source index of each frame returned by `Next`.
};

}  // namespace steadymap
