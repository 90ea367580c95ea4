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

/// How frames are uploaded.
struct UploaderOptions {
  /// Id of the robot that the frames come from, matching `[a-z][a-z0-9-]{0,62}`.
  std::string robot = "robot";

  /// Id of the sensor on it. Two sensors of one robot upload at the same time, each in its own
  /// session.
  std::string sensor = "camera";

  /// Id of the upload session, of the same form. Empty: a random one. Naming it lets a later
  /// process that pushes the same frames in the same order go on where this one stopped.
  std::string session;

  /// A message holds at most this many bytes and frames, unless one frame alone is larger. Larger
  /// messages cost fewer system calls, smaller ones keep more of the pipeline busy.
  std::size_t max_batch_bytes = std::size_t{1} << 20;
  std::size_t max_batch_frames = 8;

  /// Frames that are not durable yet take at most this much memory; `Push` waits beyond it.
  std::size_t max_buffered_bytes = std::size_t{32} << 20;

  /// A server that does not answer the opening of a stream for this long counts as unavailable.
  std::chrono::milliseconds open_timeout{20'000};

  /// Waits between reconnections.
  BackoffOptions backoff;

  /// Seed of the jitter and of the random session id. 0: from the system's random device.
  std::uint64_t seed = 0;

  /// Replaces the waiting between reconnections, and the clock: tries then take no time. For tests.
  /// Empty: really waits.
  std::function<void(std::chrono::milliseconds)> sleep;

  /// Called after each acknowledgement, from a thread of the uploader, one call at a time. It must
  /// not call the uploader.
  std::function<void(const UploadProgress&)> on_progress;

  /// Called likewise for each frame that the server refused, before `on_progress` counts it; of
  /// very many for the first 1000.
  std::function<void(const RefusedUpload&)> on_refused;

  /// Reads a frame once more, the k-th that was pushed for k = 1, 2, ...: for those whose frames
  /// come from a recording. If the server has lost frames that it had acknowledged, they are read
  /// and sent again, in their order and before those behind. Called from a thread of the uploader,
  /// one call at a time; it must not call the uploader. An error ends the upload. Empty: they are
  /// gone.
  std::function<absl::StatusOr<v1::Frame>(std::uint64_t client_seq)> read_again;

  /// Called from a thread of the uploader when the server turns out to have lost frames that it had
  /// acknowledged; it must not call the uploader. Without `read_again` and with this, as a robot
  /// that uploads what it sees has it, the upload goes on behind them and counts them as lost.
  /// Without both it ends with `DataLoss`.
  std::function<void(const LostFrames&)> on_lost;

  /// Called before each wait for a reconnection, likewise, with what went wrong.
  std::function<void(const absl::Status&, std::chrono::milliseconds delay)> on_retry;
};

/// What became of an upload.
struct UploadSummary {
  UploadProgress progress;             ///< At the end.
  std::vector<RefusedUpload> refused;  ///< In the order of their sequences.
  std::vector<LostFrames> lost;        ///< Were not sent again; by rising sequences.
};

/// Uploads frames of one robot to one map over `UploadFrames`.
///
/// Frames get the client sequences 1, 2, ... in the order they are pushed. Whatever fails on the
/// way and may heal (a lost connection, a restarted or draining server, a full disk) is retried
/// with backoff; after it, only frames that are not durable are sent again, and the server counts
/// each once. What will not heal ends the upload at once: INVALID_ARGUMENT, NOT_FOUND,
/// PERMISSION_DENIED, UNAUTHENTICATED, FAILED_PRECONDITION, UNIMPLEMENTED, UPLOAD_SUPERSEDED
/// (another session of the same robot took over), MESSAGE_TOO_LARGE, and, unless the options say
/// what to do then, a server that no longer has what it had acknowledged as durable (`DataLoss`).
///
/// Runs two threads: one writes, one reads. All functions are thread-safe, but pushes from several
/// threads are numbered in an arbitrary order.
class FrameUploader {
 public:
  /// Starts connecting at once. Each stream has a channel of its own from `open_channel`.
  FrameUploader(ChannelOpener open_channel, const MapName& map, UploaderOptions options);

  /// Ends the upload. Frames that are not durable by then may be lost.
  ~FrameUploader();

  FrameUploader(const FrameUploader&) = delete;
  FrameUploader& operator=(const FrameUploader&) = delete;

  /// Takes a frame; waits while the buffer is full.
  /// Errors: what ended the upload, or `FailedPrecondition` after `Finish`.
  absl::Status Push(v1::Frame frame);

  /// Waits until every pushed frame is integrated or was refused, and ends the upload. A refused
  /// frame is no error of the upload.
  /// Errors: what ended it before that.
  absl::StatusOr<UploadSummary> Finish();

  /// Where the upload stands.
  UploadProgress progress() const;

  /// Id of the upload session.
  const std::string& session() const;

 private:
  class Session;
  std::unique_ptr<Session> session_;
};

/// A frame that its source could not deliver.
struct UnreadableFrame {
  std::size_t index = 0;  ///< Its place among what the source delivered, from 0.
  absl::Status status;
};

/// What `UploadAll` reports on its way, from the calling thread. Each may be empty.
struct UploadAllCallbacks {
  std::function<void(const UnreadableFrame&)> on_unreadable{};
  std::function<void(const v1::Frame&)> on_frame{};  ///< Before the frame is pushed.
};

/// Pushes all frames of `source` and finishes. Frames that the source cannot read are left out.
absl::StatusOr<UploadSummary> UploadAll(FrameSource* source,
                                        FrameUploader* uploader,
                                        const UploadAllCallbacks& callbacks = {});

}  // namespace steadymap
