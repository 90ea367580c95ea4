// What an upload stream makes of its client's messages.

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/error.h"
#include "core/map_updater.h"
#include "server/request_reader.h"
#include "server/upload_request.h"
#include "server/upload_stream.h"

namespace steadymap {

/// Leaves the message as it came until there is memory for what it holds; nothing more is read
/// meanwhile.
void UploadStream::AwaitMemory() {
  const std::size_t bytes = request_.Length();
  if (map_ == nullptr || bytes > limits_.max_message_bytes) return TakeMessage({});
  std::optional<FrameBudget::Reservation> memory =
      FrameBudget::TryReserve(map_->read_account(), bytes);
  if (memory) return TakeMessage(*std::move(memory));
  FrameBudget::Reserve(
      map_->read_account(), bytes, [self = shared_from_this()](FrameBudget::Reservation granted) {
        auto shared = std::make_shared<FrameBudget::Reservation>(std::move(granted));
        self->surroundings_.decoders->Submit(
            [self, shared] { self->TakeMessage(std::move(*shared)); });
      });
}

void UploadStream::TakeMessage(FrameBudget::Reservation memory) {
  const absl::Status status = HandleMessage(std::move(memory));
  {
    const absl::MutexLock lock(&mutex_);
    reading_ = false;
    if (!status.ok() && !end_) end_ = status;
  }
  Drive();
}

absl::Status UploadStream::HandleMessage(FrameBudget::Reservation memory) {
  v1::UploadFramesRequest request;
  absl::Status status = ReadRequest(request_, UploadRequestLimits(limits_), &request);
  request_.Clear();
  if (!status.ok()) return status;
  switch (request.kind_case()) {
    case v1::UploadFramesRequest::kOpen:
      if (map_ != nullptr) {
        return InvalidField(reason::kBadValue, "open", "the stream is open already");
      }
      return WithFieldPrefix(HandleOpen(request.open()), "open");
    case v1::UploadFramesRequest::kBatch:
      if (map_ == nullptr) {
        return InvalidField(reason::kBadValue, "batch", "a stream begins with `open`");
      }
      return WithFieldPrefix(HandleBatch({std::move(*request.mutable_batch()), std::move(memory)}),
                             "batch");
    default:
      return InvalidField(reason::kBadValue, "kind", "a message must hold `open` or `batch`");
  }
}

absl::Status UploadStream::HandleOpen(const v1::UploadOpen& open) {
  absl::StatusOr<UploadTarget> target = FindUploadTarget(
      *surroundings_.maps, open.map(), open.robot(), open.sensor(), open.session());
  if (!target.ok()) return target.status();
  auto config = std::make_shared<const MapConfig>(target->map->record().config);
  wants_labels_ = KeepsObjects(config->policy);
  {
    const absl::MutexLock lock(&mutex_);
    if (absl::Status status = answers_.ChooseLevels(open); !status.ok()) return status;
    entered_ = true;
    awaiting_map_ = true;
    map_ = target->map;
    config_ = std::move(config);
    session_ = target->session;
  }
  absl::Status status = surroundings_.roster->Enter(map_->key(), session_, shared_from_this());
  if (!status.ok()) {
    const absl::MutexLock lock(&mutex_);
    entered_ = false;
    return status;
  }
  const ClientSequence known_durable(open.last_durable_client_seq());
  map_->WhenOpened(
      [self = shared_from_this(), known_durable] { self->OnMapOpened(known_durable); });
  return absl::OkStatus();
}

/// `known_durable`: the last frame that the client knows to be durable.
void UploadStream::OnMapOpened(ClientSequence known_durable) {
  const absl::Status status = WithFieldPrefix(map_->CheckReads(), "open");
  const SessionState state = map_->sessions().State(session_, map_->snapshot()->integrated());
  spdlog::debug("map {} sensor {} session {}: upload opened behind {}",
                map_->name().ToString(),
                session_.sensor.ToString(),
                session_.session,
                state.durable.value());
  v1::UploadFramesResponse response;
  v1::UploadOpened* opened = response.mutable_opened();
  opened->set_resume_client_seq(state.durable.value());
  opened->set_max_message_bytes(limits_.max_message_bytes);
  opened->set_max_image_side_px(static_cast<std::uint32_t>(kMaxImageSidePx));
  if (status.ok() && known_durable > state.durable) {
    opened->mutable_lost()->set_first(state.durable.value() + 1);
    opened->mutable_lost()->set_last(known_durable.value());
    spdlog::warn(
        "map {} sensor {} session {}: frames {} to {} were acknowledged as durable and are "
        "not here; was the store set back to an older copy?",
        map_->name().ToString(),
        session_.sensor.ToString(),
        session_.session,
        state.durable.value() + 1,
        known_durable.value());
  }
  {
    const absl::MutexLock lock(&mutex_);
    awaiting_map_ = false;
    *opened->mutable_credit() = answers_.initial_credit();
    if (status.ok()) {
      opened_ = std::move(response);
    } else if (!end_) {
      end_ = status;
    }
  }
  Drive();
}

/// Says once what a map of objects makes of frames that show it none.
void UploadStream::NoteMissingLabels(const v1::FrameBatch& batch) {
  if (!wants_labels_) return;
  const auto frame = std::find_if(batch.frames().begin(), batch.frames().end(), [](const auto& f) {
    return !f.has_labels() && !f.has_instances();
  });
  if (frame == batch.frames().end()) return;
  wants_labels_ = false;
  spdlog::warn(
      "map {} sensor {} session {}: frames have neither labels nor instances; the map keeps "
      "objects and sees none in them",
      map_->name().ToString(),
      session_.sensor.ToString(),
      session_.session);
}

absl::Status UploadStream::HandleBatch(ReadBatch batch) {
  if (absl::Status status = CheckNumbering(batch.frames); !status.ok()) return status;
  NoteMissingLabels(batch.frames);
  const auto frames = static_cast<std::uint64_t>(batch.frames.frames_size());
  const std::uint64_t bytes = batch.frames.ByteSizeLong();
  const absl::MutexLock lock(&mutex_);
  if (batch.frames.first_client_seq() <= last_read_.value()) {
    return InvalidField(reason::kBadSequence,
                        "first_client_seq",
                        absl::StrCat("client sequences rise within a stream: after ",
                                     last_read_.value(),
                                     " came ",
                                     batch.frames.first_client_seq()));
  }
  if (absl::Status status = answers_.Spend(frames, bytes); !status.ok()) return status;
  last_read_ = LastSequenceOf(batch.frames);
  if (ending_ || end_) return absl::OkStatus();
  inbox_.push_back(std::move(batch));
  return absl::OkStatus();
}

}  // namespace steadymap
