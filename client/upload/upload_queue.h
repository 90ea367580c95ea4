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

/// A message on its way: a batch that shares its frames with the queue, so nothing is copied.
class OutgoingBatch {
 public:
  /// `first_client_seq` is that of `frames[0]`; the others follow without gap.
  OutgoingBatch(std::uint64_t first_client_seq, std::vector<std::shared_ptr<v1::Frame>> frames);
  ~OutgoingBatch();
  OutgoingBatch(OutgoingBatch&& other) noexcept;
  OutgoingBatch& operator=(OutgoingBatch&&) = delete;

  const v1::UploadFramesRequest& message() const { return message_; }

 private:
  void ReleaseFrames();

  std::vector<std::shared_ptr<v1::Frame>> frames_;  ///< Own what `message_` points to.
  v1::UploadFramesRequest message_;
};

/// What becomes of frames that the server had acknowledged as durable and no longer has.
enum class LossRecovery {
  kNone,       ///< Their loss is an error.
  kGoOn,       ///< They are given up.
  kSendAgain,  ///< They are read and sent again.
};

/// The memory of an upload session: frames that are not durable yet, what the server has
/// acknowledged, and how much may be sent. Pure state: no threads, clock or network.
///
/// Bounded by its user: push only while `buffered_bytes()` allows it.
class UploadQueue {
 public:
  /// A batch holds at most so many bytes and frames, unless one frame alone has more bytes.
  UploadQueue(std::size_t max_batch_bytes,
              std::size_t max_batch_frames,
              LossRecovery recovery = LossRecovery::kNone);

  /// Appends a frame and gives it the next client sequence.
  void Push(v1::Frame frame);

  /// Starts over on a new stream at the server's resume point: what lies behind it will be sent, in
  /// order. Returns the frames that turn out to be lost now and were not known to be.
  /// Errors: `DataLoss` if frames that were acknowledged are lost and there is no recovery.
  absl::StatusOr<std::optional<LostFrames>> Open(const v1::UploadOpened& opened);

  /// Adds credit.
  void Grant(const v1::UploadCredit& credit);

  /// Notes an acknowledgement. Errors: `Internal` if it names a frame that was never sent.
  absl::Status Acknowledge(const v1::UploadAck& ack);

  /// The first frame for the next batch that must be read again before it can be sent; none where
  /// there is no such frame or no credit.
  std::optional<std::uint64_t> FrameToReadAgain() const;

  /// Gives back the frame that `FrameToReadAgain` named.
  void FillIn(std::uint64_t client_seq, v1::Frame frame);

  /// The next batch, as large as limits and credit allow, or none if there is nothing to send or
  /// too little credit. Errors: `ResourceExhausted` with reason `MESSAGE_TOO_LARGE` for a frame
  /// that no message of this server can hold.
  absl::StatusOr<std::optional<OutgoingBatch>> TakeBatch();

  /// Whether `TakeBatch` would give a batch or an error.
  bool CanTakeBatch() const;

  /// Whether everything that was pushed is sent on this stream or was durable before it.
  bool all_sent() const { return next_to_send_ > last_pushed_; }

  /// Whether everything that was pushed is integrated or refused.
  bool all_integrated() const { return integrated_ >= last_pushed_; }

  /// Serialized bytes of the frames in memory.
  std::size_t buffered_bytes() const { return buffered_bytes_; }

  /// Every frame up to this client sequence is durable or was refused.
  std::uint64_t durable_client_seq() const { return durable_; }

  UploadProgress progress() const;

  /// Frames refused so far, each once, in the order they were reported; the first 1 000 of them.
  const std::vector<RefusedUpload>& refused() const { return refused_; }

  /// Frames that were given up, by rising sequences.
  std::vector<LostFrames> lost() const;

 private:
  struct PendingFrame {
    std::shared_ptr<v1::Frame> frame;  ///< Null: must be read again.
    std::size_t bytes = 0;             ///< Serialized.
  };

  struct GivenUp {
    LostFrames frames;
    std::uint64_t count = 0;  ///< Of those that had not been refused.
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
  std::uint64_t max_message_bytes_ = 0;  ///< Of the server.

  std::deque<PendingFrame> pending_;  ///< Client sequences `durable_ + 1` to `last_pushed_`.
  std::size_t buffered_bytes_ = 0;
  std::uint64_t last_pushed_ = 0;
  std::uint64_t next_to_send_ = 1;
  std::uint64_t highest_sent_ = 0;
  std::uint64_t durable_ = 0;     ///< All up to it are durable or refused.
  std::uint64_t integrated_ = 0;  ///< All up to it are integrated or refused.

  std::uint64_t credit_bytes_ = 0;
  std::uint64_t credit_frames_ = 0;

  std::vector<RefusedUpload> refused_;
  std::set<std::uint64_t> refused_ahead_;  ///< Refused sequences above `integrated_`.
  std::uint64_t refused_behind_ = 0;       ///< How many there were up to it.
  std::vector<bool> was_refused_;          ///< By client sequence; up to the last refused one.
  std::vector<GivenUp> given_up_;          ///< By rising sequences, few.
  UploadProgress progress_;                ///< The counts that nothing above implies.
};

}  // namespace steadymap
