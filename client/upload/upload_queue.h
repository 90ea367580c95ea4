#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include "client/upload/upload_progress.h"

#include "steadymap/v1/ingest_service.pb.h"

namespace steadymap {

/// A batch ready to send. Shares its frames with the queue without a copy.
class OutgoingBatch {
 public:
  /// `frames` have consecutive client sequences; `first_client_seq` belongs to `frames[0]`.
  OutgoingBatch(std::uint64_t first_client_seq, std::vector<std::shared_ptr<v1::Frame>> frames);
  ~OutgoingBatch();
  OutgoingBatch(OutgoingBatch&& other) noexcept;
  OutgoingBatch& operator=(OutgoingBatch&&) = delete;

  const v1::UploadFramesRequest& message() const { return message_; }

 private:
  void ReleaseFrames();

  std::vector<std::shared_ptr<v1::Frame>> frames_;  ///< Own the frames referenced by `message_`.
  v1::UploadFramesRequest message_;
};

/// Policy for frames that the server had acknowledged as durable and no longer has.
enum class LossRecovery {
  kNone,       ///< The loss is an error.
  kGoOn,       ///< The frames are given up.
  kSendAgain,  ///< The frames are read and sent again.
};

/// The state of an upload session: frames that are not durable yet, acknowledgements and
/// flow-control credit. Pure state: no threads, clock or network.
///
/// The caller bounds its memory: push only while `buffered_bytes()` is below a limit.
class UploadQueue {
 public:
  /// A batch holds at most this many bytes and frames, unless a single frame exceeds
  /// `max_batch_bytes`.
  UploadQueue(std::size_t max_batch_bytes,
              std::size_t max_batch_frames,
              LossRecovery recovery = LossRecovery::kNone);

  /// Appends a frame and assigns it the next client sequence.
  void Push(v1::Frame frame);

  /// Restarts on a new stream at the server's resume point: all later frames are sent again, in
  /// order. Returns the frames newly detected as lost. Errors: `DataLoss` if acknowledged frames
  /// are lost and there is no recovery.
  absl::StatusOr<std::optional<LostFrames>> Open(const v1::UploadOpened& opened);

  /// Adds flow-control credit.
  void Grant(const v1::UploadCredit& credit);

  /// Records an acknowledgement. Errors: `Internal` if it names a frame that was never sent.
  absl::Status Acknowledge(const v1::UploadAck& ack);

  /// Returns the first frame of the next batch that must be read again before it is sent; none if
  /// there is no such frame or no credit.
  std::optional<std::uint64_t> FrameToReadAgain() const;

  /// Supplies the frame named by `FrameToReadAgain`.
  void FillIn(std::uint64_t client_seq, v1::Frame frame);

  /// Returns the next batch, as large as limits and credit allow, or none if no frame is pending or
  /// the credit is too small. Errors: `ResourceExhausted` with reason `MESSAGE_TOO_LARGE` for a
  /// frame larger than the largest message of this server.
  absl::StatusOr<std::optional<OutgoingBatch>> TakeBatch();

  /// True if `TakeBatch` would return a batch or an error.
  bool CanTakeBatch() const;

  /// True if every pushed frame was sent on this stream or was durable before it.
  bool all_sent() const { return next_to_send_ > last_pushed_; }

  /// True if every pushed frame is integrated or refused.
  bool all_integrated() const { return integrated_ >= last_pushed_; }

  /// Serialized bytes of the frames in memory.
  std::size_t buffered_bytes() const { return buffered_bytes_; }

  /// Every frame up to this client sequence is durable or was refused.
  std::uint64_t durable_client_seq() const { return durable_; }

  UploadProgress progress() const;

  /// Refused frames, each once, in the order of the reports; the first 1000 only.
  const std::vector<RefusedUpload>& refused() const { return refused_; }

  /// Frames that were given up, in ascending order.
  std::vector<LostFrames> lost() const;

 private:
  struct PendingFrame {
    std::shared_ptr<v1::Frame> frame;  ///< Null: must be read again.
    std::size_t bytes = 0;             ///< Serialized size.
  };

  struct GivenUp {
    LostFrames frames;
    std::uint64_t count = 0;  ///< Excludes frames refused before.
  };

  void MissAgain(std::uint64_t resume_client_seq);
  void SetBackIntegrated(std::uint64_t client_seq);
  std::optional<LostFrames> GiveUp(std::uint64_t resume_client_seq);

  void Settle(std::uint64_t durable_client_seq);
  void NoteIntegrated(std::uint64_t integrated_client_seq);
  void NoteRefused(const v1::RefusedFrame& refused);
  std::size_t ChooseFrameCount(std::uint64_t* batch_bytes) const;
  const PendingFrame& PendingAt(std::uint64_t client_seq) const;

  std::size_t max_batch_bytes_;
  std::size_t max_batch_frames_;
  LossRecovery recovery_;
  std::uint64_t max_message_bytes_ = 0;  ///< Limit of the server.

  std::deque<PendingFrame> pending_;  ///< Client sequences `durable_ + 1` to `last_pushed_`.
  std::size_t buffered_bytes_ = 0;
  std::uint64_t last_pushed_ = 0;
  std::uint64_t next_to_send_ = 1;
  std::uint64_t highest_sent_ = 0;
  std::uint64_t durable_ = 0;     ///< All frames up to it are durable or refused.
  std::uint64_t integrated_ = 0;  ///< All frames up to it are integrated or refused.

  std::uint64_t credit_bytes_ = 0;
  std::uint64_t credit_frames_ = 0;

  std::vector<RefusedUpload> refused_;
  std::set<std::uint64_t> refused_ahead_;  ///< Refused sequences above `integrated_`.
  std::uint64_t refused_behind_ = 0;       ///< Number of refused sequences up to `integrated_`.
  std::vector<bool> was_refused_;  ///< Indexed by client sequence - 1; up to the last refused one.
  std::vector<GivenUp> given_up_;  ///< In ascending order, few.
  UploadProgress progress_;        ///< Counts that the members above do not imply.
};

}  // namespace steadymap
