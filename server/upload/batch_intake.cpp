#include "server/upload/batch_intake.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/integration/frame_work.h"
#include "core/types/error.h"
#include "proto/batch_checksum.h"
#include "proto/convert_frame.h"
#include "server/process/system_clock.h"

namespace steadymap {
namespace {

// Memory of a frame in addition to its pixels: queue entries, headers, allocator overhead.
constexpr std::size_t kFrameOverheadBytes = 4096;

/// Estimates the memory of the frame until its integration, from its declared image sizes.
std::size_t EstimateBytes(const v1::Frame& message) {
  return DecodedBytes(message) + message.ByteSizeLong() + kFrameOverheadBytes;
}

}  // namespace

absl::Status CheckNumbering(const v1::FrameBatch& batch) {
  if (batch.frames().empty() || batch.frames_size() > kMaxBatchFrames) {
    return InvalidField(
        reason::kBadValue,
        "frames",
        absl::StrCat(
            "a batch must have 1 to ", kMaxBatchFrames, " frames, got ", batch.frames_size()));
  }
  const auto count = static_cast<std::uint64_t>(batch.frames_size());
  if (batch.first_client_seq() < 1 ||
      batch.first_client_seq() > std::numeric_limits<std::uint64_t>::max() - count) {
    return InvalidField(
        reason::kBadSequence,
        "first_client_seq",
        absl::StrCat("first_client_seq must be at least 1 and must not overflow with ",
                     count,
                     " frames, got ",
                     batch.first_client_seq()));
  }
  return absl::OkStatus();
}

ClientSequence LastSequenceOf(const v1::FrameBatch& batch) {
  return ClientSequence(batch.first_client_seq() + static_cast<std::uint64_t>(batch.frames_size()) -
                        1);
}

void BatchIntake::Start(WorkerPool* pool, UploadRoute route, ReadBatch batch, Done done) {
  std::make_shared<BatchIntake>(pool, std::move(route), std::move(batch), std::move(done))
      ->Submit();
}

BatchIntake::BatchIntake(WorkerPool* pool, UploadRoute route, ReadBatch batch, Done done)
    : pool_(pool),
      route_(std::move(route)),
      memory_(std::move(batch.memory)),
      batch_(std::move(batch.frames)),
      batch_bytes_(batch_.ByteSizeLong()),
      done_(std::move(done)),
      predecessor_(route_.predecessor) {}

BatchIntake::~BatchIntake() {
  const absl::Status status = route_.map->CheckUploads();
  Finish(!status.ok() ? status
                      : MakeError(absl::StatusCode::kUnavailable,
                                  reason::kDraining,
                                  "the server accepts no more frames"));
}

void BatchIntake::Submit() {
  const bool submitted = pool_->TrySubmit([self = shared_from_this()] { self->Run(); });
  if (submitted) return;
  Finish(MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kQueueFull,
                   "too many batches are waiting to be decoded"));
}

void BatchIntake::Run() {
  try {
    if (next_ == 0) {
      if (absl::Status status = CheckBatch(); !status.ok()) return Finish(status);
    }
    for (; next_ < batch_.frames_size(); ++next_) {
      if (route_.observer->IsAbandoned()) {
        return Finish(absl::CancelledError("the upload has ended"));
      }
      if (!TakeFrame(batch_.frames(next_), SequenceAt(next_))) return;
    }
    Finish(HandOver(/*last_piece=*/true));
  } catch (const std::exception& error) {
    Finish(MakeError(absl::StatusCode::kInternal, reason::kInternal, error.what()));
  }
}

absl::Status BatchIntake::CheckBatch() const {
  if (absl::Status status = route_.map->CheckUploads(); !status.ok()) return status;
  if (!batch_.has_images_crc32c()) return absl::OkStatus();
  const std::uint32_t found = ImagesCrc32c(batch_);
  if (found == batch_.images_crc32c()) return absl::OkStatus();
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the images of the batch from client_seq ",
                                batch_.first_client_seq(),
                                " have CRC-32C ",
                                found,
                                ", expected ",
                                batch_.images_crc32c()),
                   "images_crc32c");
}

/// Takes one frame. Returns false if it must wait for memory; `Run` is called again then.
bool BatchIntake::TakeFrame(const v1::Frame& message, ClientSequence sequence) {
  if (route_.map->sessions().IsSettled(route_.session, sequence)) return true;
  const std::size_t bytes = EstimateBytes(message);
  if (reservation_.bytes() == 0) {
    std::optional<FrameBudget::Reservation> reservation =
        FrameBudget::TryReserve(route_.map->budget_account(), bytes);
    if (!reservation) {
      // The decoded frames must be queued before the wait. Otherwise all uploads could wait for
      // memory that these frames hold.
      if (absl::Status status = HandOver(/*last_piece=*/false); !status.ok()) {
        Finish(status);
        return false;
      }
      FrameBudget::Reserve(route_.map->budget_account(),
                           bytes,
                           [self = shared_from_this()](FrameBudget::Reservation granted) {
                             self->reservation_ = std::move(granted);
                             self->Submit();
                           });
      return false;
    }
    reservation_ = *std::move(reservation);
  }
  Decode(message, sequence);
  reservation_ = {};
  return true;
}

void BatchIntake::Decode(const v1::Frame& message, ClientSequence sequence) {
  absl::StatusOr<Frame> frame = FromProto(message, route_.session.sensor, *route_.map->labels());
  absl::Status status = frame.status();
  if (status.ok()) status = CheckFrameWork(*frame, *route_.config);
  if (status.ok()) {
    status = route_.map->capture_clocks().Note(
        frame->source, frame->capture_time, message.clock_domain(), Now());
  }
  if (status.ok()) {
    frames_.push_back(
        {sequence, *std::move(frame), message.SerializeAsString(), std::move(reservation_)});
    return;
  }
  refused_.push_back({sequence, WithFieldPrefix(status, absl::StrCat("frames[", next_, "]"))});
}

absl::Status BatchIntake::HandOver(bool last_piece) {
  if (next_ == handed_over_) return absl::OkStatus();
  PendingBatch piece;
  piece.session = route_.session;
  piece.in_order = route_.in_order;
  piece.last = SequenceAt(next_ - 1);
  piece.predecessor = std::exchange(predecessor_, piece.last);
  piece.frames = std::exchange(frames_, {});
  for (const RefusedFrame& refused : refused_) piece.refused.push_back(refused.sequence);
  piece.credit_frames = static_cast<std::size_t>(next_ - handed_over_);
  piece.credit_bytes = last_piece ? batch_bytes_ : 0;
  piece.observer = route_.observer;
  handed_over_ = next_;
  route_.map->CountRefused(refused_.size());
  route_.observer->OnReceived(piece.last, std::exchange(refused_, {}));
  return route_.map->Enqueue(std::move(piece));
}

void BatchIntake::Finish(const absl::Status& status) {
  const Done done = std::exchange(done_, nullptr);
  if (done) done(status);
}

ClientSequence BatchIntake::SequenceAt(int index) const {
  return ClientSequence(batch_.first_client_seq() + static_cast<std::uint64_t>(index));
}

}  // namespace steadymap
