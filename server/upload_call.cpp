#include "server/upload_call.h"

#include <algorithm>
#include <utility>

#include <absl/strings/str_cat.h>

#include "core/error.h"
#include "proto/grpc_status.h"
#include "server/upload_request.h"

namespace steadymap {

/// What gRPC holds; keeps the call counted on the roster.
class UploadCall::Reactor final : public grpc::ServerUnaryReactor {
 public:
  /// `roster` is null for a call that was not let in.
  Reactor(std::shared_ptr<UploadCall> call, UploadRoster* roster)
      : call_(std::move(call)), roster_(roster) {}

  void OnCancel() override { call_->Finish(absl::CancelledError("the client has gone")); }

  void OnDone() override {
    if (roster_ != nullptr) roster_->LeaveCall();
    delete this;
  }

 private:
  const std::shared_ptr<UploadCall> call_;
  UploadRoster* const roster_;
};

grpc::ServerUnaryReactor* UploadCall::Start(const UploadStream::Surroundings& surroundings,
                                            const v1::UploadFrameBatchRequest& request,
                                            v1::UploadFrameBatchResponse* response) {
  const absl::Status entered = surroundings.roster->EnterCall();
  auto call = std::make_shared<UploadCall>();
  call->response_ = response;
  auto* reactor = new Reactor(call, entered.ok() ? surroundings.roster : nullptr);
  call->reactor_ = reactor;
  const absl::Status status = entered.ok() ? call->TakeIn(surroundings, request) : entered;
  if (!status.ok()) call->Finish(status);
  return reactor;
}

absl::Status UploadCall::TakeIn(const UploadStream::Surroundings& surroundings,
                                const v1::UploadFrameBatchRequest& request) {
  if (absl::Status status = CheckMessageSize(request, surroundings.limits->Get()); !status.ok()) {
    return status;
  }
  if (!v1::AckLevel_IsValid(request.wait_for())) {
    return InvalidField(reason::kBadValue,
                        "wait_for",
                        absl::StrCat("the level must be one that is known, got ",
                                     static_cast<int>(request.wait_for())));
  }
  absl::StatusOr<UploadTarget> target = FindUploadTarget(
      *surroundings.maps, request.map(), request.robot(), request.sensor(), request.session());
  if (!target.ok()) return target.status();
  if (absl::Status status = CheckNumbering(request.batch()); !status.ok()) {
    return WithFieldPrefix(status, "batch");
  }
  map_ = target->map;
  if (request.wait_for() != v1::ACK_LEVEL_UNSPECIFIED) level_ = request.wait_for();
  last_ = ClientSequence(request.batch().first_client_seq() +
                         static_cast<std::uint64_t>(request.batch().frames_size()) - 1);
  map_->WhenOpened([self = shared_from_this(), &surroundings, &request, session = target->session] {
    self->StartIntake(surroundings, request, session);
  });
  return absl::OkStatus();
}

void UploadCall::StartIntake(const UploadStream::Surroundings& surroundings,
                             const v1::UploadFrameBatchRequest& request,
                             const SessionName& session) {
  // gRPC keeps the request until the call is finished.
  if (IsAbandoned()) return;
  const std::shared_ptr<UploadCall> self = shared_from_this();
  BatchIntake::Start(surroundings.decoders,
                     {map_, session, /*in_order=*/false, ClientSequence(), self},
                     request.batch(),
                     [self](const absl::Status& status) {
                       if (!status.ok()) return self->Finish(WithFieldPrefix(status, "batch"));
                       {
                         const absl::MutexLock lock(&self->mutex_);
                         self->taken_in_ = true;
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
    if (status.ok()) FillAnswer();
  }
  reactor_->Finish(ToGrpcStatus(status));
}

bool UploadCall::IsDone() const {
  if (!taken_in_) return false;
  switch (level_) {
    case v1::ACK_LEVEL_RECEIVED:
      return true;
    case v1::ACK_LEVEL_INTEGRATED:
      return integrated_ >= last_;
    default:
      return durable_ >= last_;
  }
}

void UploadCall::FillAnswer() {
  v1::UploadAck* ack = response_->mutable_ack();
  ack->set_level(level_);
  ack->set_client_seq(last_.value());
  if (level_ != v1::ACK_LEVEL_RECEIVED) ack->set_map_seq(progress_.map_seq.value());
  if (level_ == v1::ACK_LEVEL_INTEGRATED) ack->set_revision(progress_.revision.value());
  for (const RefusedFrame& refused : refused_) *ack->add_refused() = ToProto(refused);
}

}  // namespace steadymap
