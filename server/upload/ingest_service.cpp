#include "server/upload/ingest_service.h"

#include <google/protobuf/util/time_util.h>

#include "proto/convert_geometry.h"
#include "proto/grpc_status.h"
#include "server/rpc/message_call.h"
#include "server/upload/upload_call.h"
#include "server/upload/upload_request.h"

namespace steadymap {
namespace {

absl::Status AnswerUploadState(const UploadTarget& target, v1::UploadState* response) {
  if (absl::Status status = target.map->CheckReads(); !status.ok()) return status;
  const SessionState state =
      target.map->sessions().State(target.session, target.map->snapshot()->integrated());
  response->set_resume_client_seq(state.durable.value());
  response->set_integrated_client_seq(state.integrated.value());
  if (state.last_active != Timestamp()) {
    *response->mutable_last_frame_time() = ToProto(state.last_active);
  }
  const std::optional<std::chrono::nanoseconds> ahead =
      target.map->capture_clocks().AheadOf(target.session.sensor);
  if (ahead) {
    *response->mutable_capture_time_ahead() =
        google::protobuf::util::TimeUtil::NanosecondsToDuration(ahead->count());
  }
  return absl::OkStatus();
}

}  // namespace

UploadStream::GrpcReactor* IngestService::UploadFrames(grpc::CallbackServerContext* context) {
  return UploadStream::Start(dependencies_, context);
}

grpc::ServerUnaryReactor* IngestService::UploadFrameBatch(grpc::CallbackServerContext* /*context*/,
                                                          const grpc::ByteBuffer* request,
                                                          grpc::ByteBuffer* response) {
  return UploadCall::Start(dependencies_, *request, response);
}

grpc::ServerUnaryReactor* IngestService::GetUploadState(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request,
                                                        grpc::ByteBuffer* response) {
  return StartMessageCall<v1::GetUploadStateRequest, v1::UploadState>(
      *request,
      response,
      kPlainRequestLimits,
      [this, context](const auto& call) -> grpc::ServerUnaryReactor* {
        const v1::GetUploadStateRequest& message = call.request();
        const absl::StatusOr<UploadTarget> target = FindUploadTarget(*dependencies_.maps,
                                                                     message.map(),
                                                                     message.robot(),
                                                                     message.sensor(),
                                                                     message.session());
        if (!target.ok()) return RefuseCall(target.status());
        grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
        target->map->WhenOpened([reactor, target = *target, call] {
          reactor->Finish(ToGrpcStatus(call.Answer(AnswerUploadState(target, call.response()))));
        });
        return reactor;
      });
}

}  // namespace steadymap
