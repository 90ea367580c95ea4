#include "server/upload/upload_call.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/types/error.h"
#include "proto/grpc_status.h"
#include "server/rpc/request_reader.h"
#include "server/upload/upload_request.h"

namespace steadymap {

/// The reactor owned by gRPC; keeps the call counted in the registry.
class UploadCall::Reactor final : public grpc::ServerUnaryReactor {
 public:
  /// `registry` is null for a call that was not admitted.
  Reactor(std::shared_ptr<UploadCall> call, UploadRegistry* registry)
      : call_(std::move(call)), registry_(registry) {}

  void OnCancel() override { call_->Finish(absl::CancelledError("the client has disconnected")); }

  void OnDone() override {
    if (registry_ != nullptr) registry_->LeaveCall();
    delete this;
  }

 private:
  const std::shared_ptr<UploadCall> call_;
  UploadRegistry* const registry_;
};

grpc::ServerUnaryReactor* UploadCall::Start(const UploadStream::Dependencies& dependencies,
                                            const grpc::ByteBuffer& request,
                                            grpc::ByteBuffer* response) {
  const absl::Status entered = dependencies.registry->EnterCall();
  auto call = std::make_shared<UploadCall>(dependencies);
  call->response_ = response;
  auto* reactor = new Reactor(call, entered.ok() ? dependencies.registry : nullptr);
  call->reactor_ = reactor;
  if (entered.ok()) {
    call->AwaitMemory(request);
  } else {
    call->Finish(entered);
  }
  return reactor;
}

/// Leaves the message serialized until memory for the parsed message is reserved.
void UploadCall::AwaitMemory(const grpc::ByteBuffer& request) {
  const std::size_t bytes = request.Length();
  if (bytes > dependencies_.limits->Get().max_message_bytes) return TakeMessage(request, {});
  std::optional<FrameBudget::Reservation> memory =
      FrameBudget::TryReserve(dependencies_.call_account, bytes);
  if (memory) return TakeMessage(request, *std::move(memory));
  FrameBudget::Reserve(dependencies_.call_account,
                       bytes,
                       [self = shared_from_this(), request](FrameBudget::Reservation granted) {
                         auto shared =
                             std::make_shared<FrameBudget::Reservation>(std::move(granted));
                         self->dependencies_.decoders->Submit([self, request, shared] {
                           self->TakeMessage(request, std::move(*shared));
                         });
                       });
}

void UploadCall::TakeMessage(const grpc::ByteBuffer& request, FrameBudget::Reservation memory) {
  if (IsAbandoned()) return;
  v1::UploadFrameBatchRequest message;
  absl::Status status =
      ReadRequest(request, UploadRequestLimits(dependencies_.limits->Get()), &message);
  if (status.ok()) status = StartIntake(std::move(message), std::move(memory));
  if (!status.ok()) Finish(status);
}

absl::Status UploadCall::StartIntake(v1::UploadFrameBatchRequest request,
                                     FrameBudget::Reservation memory) {
  if (!v1::AckLevel_IsValid(request.wait_for())) {
    return InvalidField(reason::kBadValue,
                        "wait_for",
                        absl::StrCat("the acknowledgement level must be a known value, got ",
                                     static_cast<int>(request.wait_for())));
  }
  absl::StatusOr<UploadTarget> target = FindUploadTarget(
      *dependencies_.maps, request.map(), request.robot(), request.sensor(), request.session());
  if (!target.ok()) return target.status();
  if (absl::Status status = CheckNumbering(request.batch()); !status.ok()) {
    return WithFieldPrefix(status, "batch");
  }
  map_ = target->map;
  if (request.wait_for() != v1::ACK_LEVEL_UNSPECIFIED) level_ = request.wait_for();
  last_ = LastSequenceOf(request.batch());
  batch_ = {std::move(*request.mutable_batch()), std::move(memory)};
  map_->WhenOpened(
      [self = shared_from_this(), session = target->session] { self->StartIntake(session); });
  return absl::OkStatus();
}

void UploadCall::StartIntake(const SessionName& session) {
  if (IsAbandoned()) return;
  const std::shared_ptr<UploadCall> self = shared_from_this();
  BatchIntake::Start(dependencies_.decoders,
                     {map_,
                      std::make_shared<const MapConfig>(map_->record().config),
                      session,
                      /*in_order=*/false,
                      ClientSequence(),
                      self},
                     std::exchange(batch_, {}),
                     [self](const absl::Status& status) {
                       if (!status.ok()) return self->Finish(WithFieldPrefix(status, "batch"));
                       {
                         const absl::MutexLock lock(&self->mutex_);
                         self->intake_done_ = true;
                       }
                       self->AnswerIfDone();
                     });
}

bool UploadCall::IsAbandoned() const {
  const absl::MutexLock lock(&mutex_);
  return finished_;
}

void UploadCall::OnReceived(ClientSequence /*through*/, std::vector<RefusedFrame> refused) {
  const absl::MutexLock lock(&mutex_);
  std::move(refused.begin(), refused.end(), std::back_inserter(refused_));
}

void UploadCall::OnDurable(const BatchProgress& progress) {
  {
    const absl::MutexLock lock(&mutex_);
    durable_ = std::max(durable_, progress.through);
    progress_.map_seq = std::max(progress_.map_seq, progress.map_seq);
  }
  AnswerIfDone();
  if (level_ == v1::ACK_LEVEL_INTEGRATED) map_->RequestCommit(progress.map_seq);
}

void UploadCall::OnIntegrated(const BatchProgress& progress) {
  {
    const absl::MutexLock lock(&mutex_);
    durable_ = std::max(durable_, progress.through);
    integrated_ = std::max(integrated_, progress.through);
    progress_.map_seq = std::max(progress_.map_seq, progress.map_seq);
    progress_.revision = std::max(progress_.revision, progress.revision);
  }
  AnswerIfDone();
}

void UploadCall::OnFailed(const absl::Status& status) { Finish(status); }

void UploadCall::AnswerIfDone() {
  {
    const absl::MutexLock lock(&mutex_);
    if (!IsDone()) return;
  }
  Finish(absl::OkStatus());
}

void UploadCall::Finish(const absl::Status& status) {
  {
    const absl::MutexLock lock(&mutex_);
    if (finished_) return;
    finished_ = true;
    if (status.ok()) *response_ = ToByteBuffer(MakeAnswer());
  }
  reactor_->Finish(ToGrpcStatus(status));
}

bool UploadCall::IsDone() const {
  if (!intake_done_) return false;
  switch (level_) {
    case v1::ACK_LEVEL_RECEIVED:
      return true;
    case v1::ACK_LEVEL_INTEGRATED:
      return integrated_ >= last_;
    default:
      return durable_ >= last_;
  }
}

v1::UploadFrameBatchResponse UploadCall::MakeAnswer() const {
  v1::UploadFrameBatchResponse response;
  v1::UploadAck* ack = response.mutable_ack();
  ack->set_level(level_);
  ack->set_client_seq(last_.value());
  if (level_ != v1::ACK_LEVEL_RECEIVED) ack->set_map_seq(progress_.map_seq.value());
  if (level_ == v1::ACK_LEVEL_INTEGRATED) ack->set_revision(progress_.revision.value());
  for (const RefusedFrame& refused : refused_) *ack->add_refused() = ToProto(refused);
  return response;
}

}  // namespace steadymap
