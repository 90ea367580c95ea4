#include "server/upload/upload_stream.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>
#include <grpcpp/server_context.h>
#include <spdlog/spdlog.h>

#include "core/policy/map_updater.h"
#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "server/rpc/request_reader.h"
#include "server/upload/upload_request.h"

namespace steadymap {

/// The reactor owned by gRPC; forwards the events to the stream.
class UploadStream::Reactor final : public GrpcReactor {
 public:
  Reactor(std::shared_ptr<UploadStream> stream, grpc::CallbackServerContext* context)
      : stream_(std::move(stream)), context_(context) {}

  void OnReadDone(bool ok) override {
    // A read also fails if the call is cancelled, of which OnCancel may tell only later.
    if (!ok && context_->IsCancelled()) stream_->OnCancelled();
    stream_->OnRead(ok);
  }

  void OnWriteDone(bool ok) override { stream_->OnWritten(ok); }

  void OnCancel() override { stream_->OnCancelled(); }

  void OnDone() override {
    stream_->OnGone();
    delete this;
  }

 private:
  const std::shared_ptr<UploadStream> stream_;
  grpc::CallbackServerContext* const context_;  ///< Of gRPC; outlives this object.
};

UploadStream::GrpcReactor* UploadStream::Start(const Dependencies& dependencies,
                                               grpc::CallbackServerContext* context) {
  auto stream = std::make_shared<UploadStream>(dependencies);
  auto* reactor = new Reactor(stream, context);
  stream->reactor_ = reactor;
  stream->Drive();
  return reactor;
}

UploadStream::UploadStream(const Dependencies& dependencies)
    : dependencies_(dependencies),
      limits_(dependencies.limits->Get()),
      responses_({limits_.upload_window_frames, limits_.upload_window_bytes}) {}

bool UploadStream::IsAbandoned() const {
  const absl::MutexLock lock(&mutex_);
  return end_status_.has_value();
}

void UploadStream::OnReceived(ClientSequence through, std::vector<RefusedFrame> refused) {
  {
    const absl::MutexLock lock(&mutex_);
    last_accepted_ = through;
    responses_.NoteReceived(through, std::move(refused));
  }
  Drive();
}

void UploadStream::OnDurable(const BatchProgress& progress) {
  {
    const absl::MutexLock lock(&mutex_);
    if (progress.through > durable_.through || progress.ends_session) durable_ = progress;
    responses_.NoteDurable(progress);
  }
  Drive();
}

void UploadStream::OnIntegrated(const BatchProgress& progress) {
  {
    const absl::MutexLock lock(&mutex_);
    integrated_ = std::max(integrated_, progress.through);
    end_integrated_ = end_integrated_ || progress.ends_session;
    responses_.NoteIntegrated(progress);
  }
  Drive();
}

void UploadStream::OnFailed(const absl::Status& status) { End(status); }

void UploadStream::End(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    if (!end_status_) end_status_ = status;
  }
  Drive();
}

void UploadStream::Drain(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    if (!drain_status_) drain_status_ = status;
    // These frames are not acknowledged at any level, so the client sends them again, for example
    // to the next server process.
    inbox_.clear();
  }
  Drive();
}

void UploadStream::OnRead(bool ok) {
  if (ok) return AwaitMemory();
  {
    const absl::MutexLock lock(&mutex_);
    reading_ = false;
    if (!drain_status_) drain_status_ = absl::OkStatus();
  }
  Drive();
}

/// Leaves the message serialized until memory for the parsed message is reserved. No other message
/// is read in the meantime.
void UploadStream::AwaitMemory() {
  const std::size_t bytes = request_.Length();
  if (map_ == nullptr || bytes > limits_.max_message_bytes) return TakeMessage({});
  std::optional<FrameBudget::Reservation> memory =
      FrameBudget::TryReserve(map_->read_account(), bytes);
  if (memory) return TakeMessage(*std::move(memory));
  FrameBudget::Reserve(
      map_->read_account(), bytes, [self = shared_from_this()](FrameBudget::Reservation granted) {
        auto shared = std::make_shared<FrameBudget::Reservation>(std::move(granted));
        self->dependencies_.decoders->Submit(
            [self, shared] { self->TakeMessage(std::move(*shared)); });
      });
}

void UploadStream::TakeMessage(FrameBudget::Reservation memory) {
  const absl::Status status = HandleMessage(std::move(memory));
  {
    const absl::MutexLock lock(&mutex_);
    reading_ = false;
    if (!status.ok() && !end_status_) end_status_ = status;
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
        return InvalidField(reason::kBadValue, "open", "the stream is already open");
      }
      return WithFieldPrefix(HandleOpen(request.open()), "open");
    case v1::UploadFramesRequest::kBatch:
      if (map_ == nullptr) {
        return InvalidField(
            reason::kBadValue, "batch", "the first message of a stream must be `open`");
      }
      return WithFieldPrefix(HandleBatch({std::move(*request.mutable_batch()), std::move(memory)}),
                             "batch");
    default:
      return InvalidField(reason::kBadValue, "kind", "a message must contain `open` or `batch`");
  }
}

absl::Status UploadStream::HandleOpen(const v1::UploadOpen& open) {
  absl::StatusOr<UploadTarget> target = FindUploadTarget(
      *dependencies_.maps, open.map(), open.robot(), open.sensor(), open.session());
  if (!target.ok()) return target.status();
  auto config = std::make_shared<const MapConfig>(target->map->record().config);
  missing_labels_.SetNeedsLabels(NeedsLabels(config->policy));
  {
    const absl::MutexLock lock(&mutex_);
    if (absl::Status status = responses_.ChooseLevels(open); !status.ok()) return status;
    entered_ = true;
    awaiting_map_ = true;
    map_ = target->map;
    config_ = std::move(config);
    session_ = target->session;
  }
  absl::Status status = dependencies_.registry->Enter(map_->key(), session_, shared_from_this());
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

void UploadStream::OnMapOpened(ClientSequence known_durable) {
  const absl::Status status = WithFieldPrefix(map_->CheckReads(), "open");
  v1::UploadFramesResponse response =
      MakeOpenedResponse(map_.get(), session_, known_durable, limits_);
  {
    const absl::MutexLock lock(&mutex_);
    awaiting_map_ = false;
    *response.mutable_opened()->mutable_credit() = responses_.initial_credit();
    if (status.ok()) {
      opened_ = std::move(response);
    } else if (!end_status_) {
      end_status_ = status;
    }
  }
  Drive();
}

absl::Status UploadStream::HandleBatch(ReadBatch batch) {
  if (absl::Status status = CheckNumbering(batch.frames); !status.ok()) return status;
  missing_labels_.Check(batch.frames, map_->name(), session_);
  const auto frames = static_cast<std::uint64_t>(batch.frames.frames_size());
  const std::uint64_t bytes = batch.frames.ByteSizeLong();
  const absl::MutexLock lock(&mutex_);
  if (batch.frames.first_client_seq() <= last_read_.value()) {
    return InvalidField(reason::kBadSequence,
                        "first_client_seq",
                        absl::StrCat("client sequences must increase within a stream: last was ",
                                     last_read_.value(),
                                     ", got ",
                                     batch.frames.first_client_seq()));
  }
  if (absl::Status status = responses_.Spend(frames, bytes); !status.ok()) return status;
  last_read_ = LastSequenceOf(batch.frames);
  if (drain_status_ || end_status_) return absl::OkStatus();
  inbox_.push_back(std::move(batch));
  return absl::OkStatus();
}

void UploadStream::OnWritten(bool ok) {
  {
    const absl::MutexLock lock(&mutex_);
    writing_ = false;
    if (!ok) broken_ = true;
  }
  Drive();
}

void UploadStream::OnCancelled() {
  {
    const absl::MutexLock lock(&mutex_);
    broken_ = true;
    if (!end_status_) end_status_ = absl::CancelledError("the client has disconnected");
  }
  Drive();
}

void UploadStream::OnGone() {
  bool entered = false;
  absl::Status status;
  {
    const absl::MutexLock lock(&mutex_);
    entered = std::exchange(entered_, false);
    if (end_status_) status = *end_status_;
  }
  if (!entered) return;
  dependencies_.registry->Leave(map_->key(), session_, this);
  spdlog::debug("map {} sensor {} session {}: upload ended: {}",
                map_->name().ToString(),
                session_.sensor.ToString(),
                session_.session,
                status.ToString());
}

void UploadStream::Drive() {
  // Keeps the stream alive: another thread may release the last reference during the loop.
  const std::shared_ptr<UploadStream> self = shared_from_this();
  {
    const absl::MutexLock lock(&mutex_);
    if (driving_) return;
    driving_ = true;
  }
  while (true) {
    Action action = Action::kNone;
    {
      const absl::MutexLock lock(&mutex_);
      action = Decide();
      if (action == Action::kNone) {
        driving_ = false;
        return;
      }
    }
    Perform(action);
  }
}

UploadStream::Action UploadStream::Decide() {
  if (finished_) return Action::kNone;
  if (!end_status_ && drain_status_ && IsSettled() && !opened_ && !responses_.HasNext())
    end_status_ = *drain_status_;
  // Pending messages are written before the stream ends, unless the client has disconnected.
  if (!writing_ && !broken_ && (opened_ || responses_.HasNext())) {
    writing_ = true;
    response_ = ToByteBuffer(opened_ ? *std::move(opened_) : responses_.TakeNext());
    opened_.reset();
    return Action::kWrite;
  }
  if (end_status_) {
    if (writing_) return Action::kNone;
    finished_ = true;
    return Action::kFinish;
  }
  if (!intake_running_ && !inbox_.empty()) {
    intake_running_ = true;
    return Action::kStartIntake;
  }
  if (drain_status_ && !intake_running_ && durable_.through >= last_accepted_) {
    if (!end_queued_ && IsSessionOver()) {
      end_queued_ = true;
      return Action::kEndSession;
    }
    if (!commit_requested_ && (!end_queued_ || durable_.ends_session)) {
      commit_requested_ = true;
      return Action::kRequestCommit;
    }
  }
  if (!drain_status_ && !reading_ && !awaiting_map_ && inbox_.empty()) {
    reading_ = true;
    return Action::kRead;
  }
  return Action::kNone;
}

void UploadStream::Perform(Action action) {
  switch (action) {
    case Action::kRead:
      reactor_->StartRead(&request_);
      break;
    case Action::kWrite:
      reactor_->StartWrite(&response_);
      break;
    case Action::kStartIntake:
      StartIntake();
      break;
    case Action::kEndSession:
      EndSession();
      break;
    case Action::kRequestCommit:
      RequestCommit();
      break;
    case Action::kFinish: {
      absl::Status status;
      {
        const absl::MutexLock lock(&mutex_);
        status = *end_status_;
      }
      reactor_->Finish(ToGrpcStatus(status));
      break;
    }
    case Action::kNone:
      break;
  }
}

void UploadStream::StartIntake() {
  ReadBatch batch;
  ClientSequence predecessor;
  {
    const absl::MutexLock lock(&mutex_);
    // `Drain` may have emptied the inbox meanwhile.
    if (inbox_.empty()) {
      intake_running_ = false;
      return;
    }
    batch = std::move(inbox_.front());
    inbox_.pop_front();
    predecessor = std::exchange(last_in_intake_, LastSequenceOf(batch.frames));
  }
  const std::shared_ptr<UploadStream> self = shared_from_this();
  BatchIntake::Start(dependencies_.decoders,
                     {map_, config_, session_, /*in_order=*/true, predecessor, self},
                     std::move(batch),
                     [self](const absl::Status& status) {
                       {
                         const absl::MutexLock lock(&self->mutex_);
                         self->intake_running_ = false;
                         if (!status.ok() && !self->end_status_) {
                           self->end_status_ = WithFieldPrefix(status, "batch");
                         }
                       }
                       self->Drive();
                     });
}

/// True if the client has half-closed the stream of a map that decides at the end of sessions. A
/// stream that was cut, or that the server drains, continues later.
bool UploadStream::IsSessionOver() const {
  return drain_status_ && drain_status_->ok() && map_ != nullptr && !awaiting_map_ &&
         HasSessions(config_->policy);
}

void UploadStream::EndSession() {
  PendingBatch end;
  end.session = session_;
  end.in_order = true;
  end.ends_session = true;
  end.observer = shared_from_this();
  {
    const absl::MutexLock lock(&mutex_);
    end.predecessor = last_accepted_;
    end.last = last_accepted_;
  }
  const absl::Status status = map_->Enqueue(std::move(end));
  if (!status.ok()) End(status);
}

void UploadStream::RequestCommit() {
  std::shared_ptr<MapRuntime> map;
  MapSequence target;
  {
    const absl::MutexLock lock(&mutex_);
    map = map_;
    target = durable_.map_seq;
  }
  if (map != nullptr) map->RequestCommit(target);
}

/// True if all accepted frames, and the decisions on the session, are integrated.
bool UploadStream::IsSettled() const {
  return inbox_.empty() && !intake_running_ && !awaiting_map_ && integrated_ >= last_accepted_ &&
         (end_integrated_ || !IsSessionOver());
}

}  // namespace steadymap
