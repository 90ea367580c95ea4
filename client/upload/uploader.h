#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/transport/backoff.h"
#include "client/transport/channel.h"
#include "client/upload/frame_source.h"
#include "client/upload/upload_progress.h"
#include "core/types/identifiers.h"

namespace steadymap {

/// Options of an upload.
struct UploaderOptions {
  /// Id of the robot that recorded the frames; matches `[a-z][a-z0-9-]{0,62}`.
  std::string robot = "robot";

  /// Id of the sensor on the robot. Two sensors of one robot upload concurrently, each in its own
  /// session.
  std::string sensor = "camera";

  /// Id of the upload session, of the same form as `robot`. Empty: a random id. With a fixed id, a
  /// later process that pushes the same frames in the same order continues the upload.
  std::string session;

  /// A message holds at most this many bytes and frames, unless a single frame is larger. Larger
  /// messages need fewer system calls; smaller ones keep the pipeline stages busy in parallel.
  std::size_t max_batch_bytes = std::size_t{1} << 20;
  std::size_t max_batch_frames = 8;

  /// Memory limit of frames that are not durable yet; `Push` blocks above it.
  std::size_t max_buffered_bytes = std::size_t{32} << 20;

  /// A server that does not answer the opening of a stream within this time counts as unavailable.
  std::chrono::milliseconds open_timeout{20'000};

  /// Delays between reconnections.
  BackoffOptions backoff;

  /// Seed of the jitter and of the random session id. 0: from the system's random device.
  std::uint64_t seed = 0;

  /// Replaces the wait between reconnections and the clock; attempts then take no time. For tests.
  /// Empty: waits in real time.
  std::function<void(std::chrono::milliseconds)> sleep;

  /// Called after each acknowledgement, from a thread of the uploader, one call at a time. Must not
  /// call the uploader.
  std::function<void(const UploadProgress&)> on_progress;

  /// Called for each refused frame before `on_progress` counts it, at most 1000 times, from a
  /// thread of the uploader, one call at a time. Must not call the uploader.
  std::function<void(const RefusedUpload&)> on_refused;

  /// Reads the k-th pushed frame (k = 1, 2, ...) again. For frames from a recording. If the server
  /// has lost frames that it had acknowledged, the uploader reads and resends them in order, before
  /// all later frames. Called from a thread of the uploader, one call at a time. Must not call the
  /// uploader. An error ends the upload. Empty: lost frames cannot be resent.
  std::function<absl::StatusOr<v1::Frame>(std::uint64_t client_seq)> read_again;

  /// Called from a thread of the uploader when the server has lost frames that it had acknowledged.
  /// Must not call the uploader. With `on_lost` but without `read_again` (a robot that uploads live
  /// frames), the upload continues after the lost frames and counts them as lost. Without both, the
  /// upload ends with `DataLoss`.
  std::function<void(const LostFrames&)> on_lost;

  /// Called before each wait for a reconnection with the error and the delay, from a thread of the
  /// uploader, one call at a time. Must not call the uploader.
  std::function<void(const absl::Status&, std::chrono::milliseconds delay)> on_retry;
};

/// Result of an upload.
struct UploadSummary {
  UploadProgress progress;             ///< At the end of the upload.
  std::vector<RefusedUpload> refused;  ///< In the order of their sequences.
  std::vector<LostFrames> lost;        ///< Not resent; in ascending order.
};

/// Uploads frames of one robot to one map over `UploadFrames`.
///
/// Frames get the client sequences 1, 2, ... in the order they are pushed. Transient errors (a lost
/// connection, a restarted or draining server, a full disk) are retried with backoff. After a
/// reconnection only frames that are not durable are resent; the server integrates each frame once.
/// Permanent errors end the upload at once: INVALID_ARGUMENT, NOT_FOUND, PERMISSION_DENIED,
/// UNAUTHENTICATED, FAILED_PRECONDITION, UNIMPLEMENTED, UPLOAD_SUPERSEDED (another session of the
/// same robot has replaced this one), MESSAGE_TOO_LARGE, and `DataLoss` (the server no longer has
/// frames that it acknowledged as durable), unless `read_again` or `on_lost` is set.
///
/// Runs two threads: one writes, one reads. All functions are thread-safe; concurrent pushes are
/// numbered in an arbitrary order.
class FrameUploader {
 public:
  /// Starts connecting at once. Each stream uses a new channel from `open_channel`.
  FrameUploader(ChannelOpener open_channel, const MapName& map, UploaderOptions options);

  /// Ends the upload. Frames that are not durable yet may be lost.
  ~FrameUploader();

  FrameUploader(const FrameUploader&) = delete;
  FrameUploader& operator=(const FrameUploader&) = delete;

  /// Accepts a frame; blocks while the buffer is full. Errors: the error that ended the upload;
  /// `FailedPrecondition` after `Finish`.
  absl::Status Push(v1::Frame frame);

  /// Waits until every pushed frame is integrated or refused, and ends the upload. A refused frame
  /// is no error of the upload. Errors: the error that ended the upload before that.
  absl::StatusOr<UploadSummary> Finish();

  /// Returns the current progress.
  UploadProgress progress() const;

  /// Id of the upload session.
  const std::string& session() const;

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

/// A frame that its source failed to deliver.
struct UnreadableFrame {
  std::size_t index = 0;  ///< Number of the call of `Next`, from 0.
  absl::Status status;
};

/// Callbacks of `UploadAll`, called from the calling thread. Each may be empty.
struct UploadAllCallbacks {
  std::function<void(const UnreadableFrame&)> on_unreadable{};
  std::function<void(const v1::Frame&)> on_frame{};  ///< Before the frame is pushed.
};

/// Pushes all frames of `source` and finishes. Skips frames that the source cannot read.
absl::StatusOr<UploadSummary> UploadAll(FrameSource* source,
                                        FrameUploader* uploader,
                                        const UploadAllCallbacks& callbacks = {});

}  // namespace steadymap
