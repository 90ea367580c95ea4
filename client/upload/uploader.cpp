#include "client/upload/uploader.h"

#include <optional>
#include <utility>

#include "client/upload/upload_session.h"

namespace steadymap {

FrameUploader::FrameUploader(ChannelOpener open_channel,
                             const MapName& map,
                             UploaderOptions options)
    : session_(std::make_unique<Session>(std::move(open_channel), map, std::move(options))) {}

FrameUploader::~FrameUploader() = default;

absl::Status FrameUploader::Push(v1::Frame frame) { return session_->Push(std::move(frame)); }

absl::StatusOr<UploadSummary> FrameUploader::Finish() { return session_->Finish(); }

UploadProgress FrameUploader::progress() const { return session_->progress(); }

const std::string& FrameUploader::session() const { return session_->name(); }

absl::StatusOr<UploadSummary> UploadAll(FrameSource* source,
                                        FrameUploader* uploader,
                                        const UploadAllCallbacks& callbacks) {
  for (std::size_t index = 0;; ++index) {
    absl::StatusOr<std::optional<v1::Frame>> frame = source->Next();
    if (!frame.ok()) {
      if (callbacks.on_unreadable) callbacks.on_unreadable({index, frame.status()});
      continue;
    }
    if (!frame->has_value()) break;
    if (callbacks.on_frame) callbacks.on_frame(**frame);
    const absl::Status pushed = uploader->Push(std::move(**frame));
    if (!pushed.ok()) return pushed;
  }
  return uploader->Finish();
}

}  // namespace steadymap
