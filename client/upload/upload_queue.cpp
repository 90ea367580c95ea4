#include "client/upload/upload_queue.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <absl/strings/str_cat.h>
#include <google/protobuf/io/coded_stream.h>

#include "core/types/error.h"
#include "proto/batch_checksum.h"
#include "proto/convert_status.h"

namespace steadymap {
namespace {

// Enough for a diagnosis; bounds the memory for a robot that sends only invalid frames.
constexpr std::size_t kMaxKeptRefusals = 1000;

// Tag and length of the batch within UploadFramesRequest, rounded up.
constexpr std::uint64_t kEnvelopeBytes = 16;

constexpr std::uint64_t kChecksumBytes = 5;

// Used for a server that reports no limit.
constexpr std::uint64_t kUnlimitedBytes = std::numeric_limits<std::uint64_t>::max();

using google::protobuf::io::CodedOutputStream;

// Returns the serialized bytes of a batch without its frames.
std::uint64_t EmptyBatchBytes(std::uint64_t first_client_seq) {
  return 1 + CodedOutputStream::VarintSize64(first_client_seq) + kChecksumBytes;
}

// Returns the serialized bytes that a frame adds to its batch.
std::uint64_t BytesInBatch(std::size_t frame_bytes) {
  return 1 + CodedOutputStream::VarintSize64(frame_bytes) + frame_bytes;
}

}  // namespace

OutgoingBatch::OutgoingBatch(std::uint64_t first_client_seq,
                             std::vector<std::shared_ptr<v1::Frame>> frames)
    : frames_(std::move(frames)) {
  v1::FrameBatch& batch = *message_.mutable_batch();
  batch.set_first_client_seq(first_client_seq);
  for (const std::shared_ptr<v1::Frame>& frame : frames_) {
    batch.mutable_frames()->UnsafeArenaAddAllocated(frame.get());
  }
  batch.set_images_crc32c(ImagesCrc32c(batch));
}

OutgoingBatch::~OutgoingBatch() { ReleaseFrames(); }

OutgoingBatch::OutgoingBatch(OutgoingBatch&& other) noexcept
    : frames_(std::move(other.frames_)), message_(std::move(other.message_)) {
  other.frames_.clear();
}

// The message does not own its frames and must release them before its destruction.
void OutgoingBatch::ReleaseFrames() {
  if (frames_.empty()) return;
  auto& frames = *message_.mutable_batch()->mutable_frames();
  while (!frames.empty()) frames.UnsafeArenaReleaseLast();
}

UploadQueue::UploadQueue(std::size_t max_batch_bytes,
                         std::size_t max_batch_frames,
                         LossRecovery recovery)
    : max_batch_bytes_(max_batch_bytes),
      max_batch_frames_(std::max<std::size_t>(max_batch_frames, 1)),
      recovery_(recovery) {}

void UploadQueue::Push(v1::Frame frame) {
  ++last_pushed_;
  // An earlier run of this session already uploaded this frame.
  if (last_pushed_ <= durable_) return;
  const std::size_t bytes = frame.ByteSizeLong();
  pending_.push_back({std::make_shared<v1::Frame>(std::move(frame)), bytes});
  buffered_bytes_ += bytes;
}

absl::StatusOr<std::optional<LostFrames>> UploadQueue::Open(const v1::UploadOpened& opened) {
  const std::uint64_t resume = opened.resume_client_seq();
  std::optional<LostFrames> lost;
  if (resume >= durable_) {
    Settle(resume);
  } else if (recovery_ == LossRecovery::kSendAgain) {
    lost = LostFrames{resume + 1, durable_};
    MissAgain(resume);
  } else if (recovery_ == LossRecovery::kGoOn) {
    lost = GiveUp(resume);
  } else {
    return MakeError(absl::StatusCode::kDataLoss,
                     {},
                     absl::StrCat("the server acknowledged frames up to ",
                                  durable_,
                                  " of this session as durable, but now has only frames up to ",
                                  resume));
  }
  next_to_send_ = durable_ + 1;
  credit_bytes_ = opened.credit().bytes();
  credit_frames_ = opened.credit().frames();
  max_message_bytes_ =
      opened.max_message_bytes() > 0 ? opened.max_message_bytes() : kUnlimitedBytes;
  return lost;
}

// Marks the lost frames as pending; they are read again when they are sent.
void UploadQueue::MissAgain(std::uint64_t resume_client_seq) {
  const std::uint64_t last_missing = std::min(durable_, last_pushed_);
  if (last_missing > resume_client_seq) {
    pending_.insert(pending_.begin(), last_missing - resume_client_seq, PendingFrame());
  }
  durable_ = resume_client_seq;
  SetBackIntegrated(resume_client_seq);
}

void UploadQueue::SetBackIntegrated(std::uint64_t client_seq) {
  const std::uint64_t last_known = std::min<std::uint64_t>(integrated_, was_refused_.size());
  for (std::uint64_t sequence = client_seq + 1; sequence <= last_known; ++sequence) {
    if (!was_refused_[sequence - 1]) continue;
    refused_ahead_.insert(sequence);
    --refused_behind_;
  }
  integrated_ = std::min(integrated_, client_seq);
}

// Continues after the last durable frame. Returns none if all lost frames were given up before.
std::optional<LostFrames> UploadQueue::GiveUp(std::uint64_t resume_client_seq) {
  const LostFrames lost{resume_client_seq + 1, durable_};
  if (!given_up_.empty() && given_up_.back().frames == lost) return std::nullopt;
  SetBackIntegrated(resume_client_seq);
  while (!given_up_.empty() && given_up_.back().frames.first >= lost.first) given_up_.pop_back();
  GivenUp given_up{lost, std::min(lost.last, last_pushed_) + 1 - lost.first};
  for (std::uint64_t i = lost.first; i <= std::min<std::uint64_t>(lost.last, was_refused_.size());
       ++i) {
    if (was_refused_[i - 1]) --given_up.count;
  }
  given_up_.push_back(given_up);
  return lost;
}

std::vector<LostFrames> UploadQueue::lost() const {
  std::vector<LostFrames> lost;
  lost.reserve(given_up_.size());
  for (const GivenUp& given_up : given_up_) lost.push_back(given_up.frames);
  return lost;
}

std::optional<std::uint64_t> UploadQueue::FrameToReadAgain() const {
  const std::uint64_t most = std::min(credit_frames_, std::uint64_t{max_batch_frames_});
  const std::uint64_t end = std::min(next_to_send_ + most, last_pushed_ + 1);
  std::uint64_t bytes = 0;
  for (std::uint64_t sequence = next_to_send_; sequence < end; ++sequence) {
    const PendingFrame& pending = PendingAt(sequence);
    if (pending.frame == nullptr) return sequence;
    bytes += pending.bytes;
    if (bytes >= max_batch_bytes_) break;
  }
  return std::nullopt;
}

void UploadQueue::FillIn(std::uint64_t client_seq, v1::Frame frame) {
  PendingFrame& pending = pending_[client_seq - durable_ - 1];
  pending.bytes = frame.ByteSizeLong();
  pending.frame = std::make_shared<v1::Frame>(std::move(frame));
  buffered_bytes_ += pending.bytes;
}

void UploadQueue::Grant(const v1::UploadCredit& credit) {
  credit_bytes_ += credit.bytes();
  credit_frames_ += credit.frames();
}

absl::Status UploadQueue::Acknowledge(const v1::UploadAck& ack) {
  if (ack.client_seq() >= next_to_send_) {
    return MakeError(absl::StatusCode::kInternal,
                     reason::kInternal,
                     absl::StrCat("the server acknowledged frame ",
                                  ack.client_seq(),
                                  ", but only ",
                                  next_to_send_ - 1,
                                  " were sent"));
  }
  for (const v1::RefusedFrame& refused : ack.refused()) NoteRefused(refused);
  if (ack.level() >= v1::ACK_LEVEL_DURABLE) Settle(ack.client_seq());
  if (ack.level() >= v1::ACK_LEVEL_INTEGRATED) NoteIntegrated(ack.client_seq());
  progress_.revision = std::max(progress_.revision, ack.revision());
  return absl::OkStatus();
}

void UploadQueue::Settle(std::uint64_t durable_client_seq) {
  if (durable_client_seq <= durable_) return;
  const std::size_t settled =
      std::min<std::uint64_t>(pending_.size(), durable_client_seq - durable_);
  for (std::size_t i = 0; i < settled; ++i) buffered_bytes_ -= pending_[i].bytes;
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(settled));
  durable_ = durable_client_seq;
}

void UploadQueue::NoteIntegrated(std::uint64_t integrated_client_seq) {
  // Frames that were given up count as processed.
  for (const GivenUp& given_up : given_up_) {
    if (integrated_client_seq + 1 < given_up.frames.first) break;
    integrated_client_seq = std::max(integrated_client_seq, given_up.frames.last);
  }
  integrated_ = std::max(integrated_, integrated_client_seq);
  while (!refused_ahead_.empty() && *refused_ahead_.begin() <= integrated_) {
    refused_ahead_.erase(refused_ahead_.begin());
    ++refused_behind_;
  }
}

void UploadQueue::NoteRefused(const v1::RefusedFrame& refused) {
  // Ignores a repeated report after a reconnection and a sequence that was never sent.
  if (refused.client_seq() <= integrated_ || refused.client_seq() >= next_to_send_) return;
  if (!refused_ahead_.insert(refused.client_seq()).second) return;
  if (was_refused_.size() < refused.client_seq()) was_refused_.resize(refused.client_seq());
  was_refused_[refused.client_seq() - 1] = true;
  if (refused_.size() < kMaxKeptRefusals) {
    refused_.push_back({refused.client_seq(), FromProto(refused.status())});
  }
}

bool UploadQueue::CanTakeBatch() const {
  if (all_sent() || PendingAt(next_to_send_).frame == nullptr) return false;
  const std::uint64_t bytes =
      EmptyBatchBytes(next_to_send_) + BytesInBatch(PendingAt(next_to_send_).bytes);
  return (credit_frames_ > 0 && bytes <= credit_bytes_) ||
         bytes + kEnvelopeBytes > max_message_bytes_;
}

absl::StatusOr<std::optional<OutgoingBatch>> UploadQueue::TakeBatch() {
  if (!CanTakeBatch()) return std::nullopt;
  std::uint64_t batch_bytes = 0;
  const std::size_t count = ChooseFrameCount(&batch_bytes);
  if (count == 0) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     reason::kMessageTooLarge,
                     absl::StrCat("frame ",
                                  next_to_send_,
                                  " has ",
                                  PendingAt(next_to_send_).bytes,
                                  " bytes, but the server takes messages of at most ",
                                  max_message_bytes_,
                                  " bytes"));
  }
  std::vector<std::shared_ptr<v1::Frame>> frames;
  for (std::size_t i = 0; i < count; ++i) frames.push_back(PendingAt(next_to_send_ + i).frame);
  OutgoingBatch batch(next_to_send_, std::move(frames));
  next_to_send_ += count;
  credit_bytes_ -= batch_bytes;
  credit_frames_ -= count;

  progress_.bytes_sent += batch_bytes;
  for (std::uint64_t sequence = next_to_send_ - count; sequence < next_to_send_; ++sequence) {
    ++(sequence > highest_sent_ ? progress_.sent : progress_.sent_again);
  }
  highest_sent_ = std::max(highest_sent_, next_to_send_ - 1);
  return batch;
}

// Returns the number of frames for the next batch; 0 if the first frame exceeds the message limit
// of the server.
std::size_t UploadQueue::ChooseFrameCount(std::uint64_t* batch_bytes) const {
  const std::uint64_t available = last_pushed_ + 1 - next_to_send_;
  const std::uint64_t most_frames =
      std::min({available, credit_frames_, std::uint64_t{max_batch_frames_}});
  std::uint64_t bytes = EmptyBatchBytes(next_to_send_);
  std::size_t count = 0;
  while (count == 0 || (count < most_frames && PendingAt(next_to_send_ + count).frame != nullptr)) {
    const std::uint64_t grown = bytes + BytesInBatch(PendingAt(next_to_send_ + count).bytes);
    if (grown + kEnvelopeBytes > max_message_bytes_) break;
    if (count > 0 && (grown > max_batch_bytes_ || grown > credit_bytes_)) break;
    bytes = grown;
    ++count;
  }
  *batch_bytes = bytes;
  return count;
}

const UploadQueue::PendingFrame& UploadQueue::PendingAt(std::uint64_t client_seq) const {
  return pending_[client_seq - durable_ - 1];
}

UploadProgress UploadQueue::progress() const {
  UploadProgress progress = progress_;
  const auto refused_durable = static_cast<std::uint64_t>(
      std::distance(refused_ahead_.begin(), refused_ahead_.upper_bound(durable_)));
  progress.pushed = last_pushed_;
  progress.durable = std::min(durable_, last_pushed_) - refused_behind_ - refused_durable;
  progress.integrated = std::min(integrated_, last_pushed_) - refused_behind_;
  for (const GivenUp& given_up : given_up_) {
    progress.lost += given_up.count;
    progress.durable -= given_up.count;
    if (given_up.frames.last <= integrated_) progress.integrated -= given_up.count;
  }
  progress.refused = refused_behind_ + refused_ahead_.size();
  return progress;
}

}  // namespace steadymap
