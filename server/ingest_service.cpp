#include "server/ingest_service.h"

#include "proto/convert_geometry.h"
#include "proto/grpc_status.h"
#include "server/upload_call.h"
#include "server/upload_request.h"

namespace steadymap {
namespace {

absl::Status AnswerUploadState(const MapDirectory& maps,
                               const v1::GetUploadStateRequest& request,
                               v1::UploadState* response) {
  const absl::StatusOr<UploadTarget> target =
      FindUploadTarget(maps, request.map(), request.robot(), request.session());
  if (!target.ok()) return target.status();
  const SessionState state =
      target->map->sessions().State(target->session, target->map->snapshot()->revision);
  response->set_resume_client_seq(state.durable.value());
  response->set_integrated_client_seq(state.integrated.value());
  if (state.last_active != Timestamp()) {
    *response->mutable_last_frame_time() = ToProto(state.last_active);
  }
  return absl::OkStatus();
}

}  // namespace

UploadStream::GrpcReactor* IngestService::UploadFrames(grpc::CallbackServerContext* /*context*/) {
  return UploadStream::Start(surroundings_);
}

grpc::ServerUnaryReactor* IngestService::UploadFrameBatch(
    grpc::CallbackServerContext* /*context*/,
    const v1::UploadFrameBatchRequest* request,
    v1::UploadFrameBatchResponse* response) {
  return UploadCall::Start(surroundings_, *request, response);
}

grpc::ServerUnaryReactor* IngestService::GetUploadState(grpc::CallbackServerContext* context,
                                                        const v1::GetUploadStateRequest* request,
                                                        v1::UploadState* response) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(ToGrpcStatus(AnswerUploadState(*surroundings_.maps, *request, response)));
  return reactor;
}

}  // namespace steadymap
