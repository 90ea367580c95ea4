#pragma once

#include "server/upload_stream.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"

namespace steadymap {

/// Takes frames from robots; see proto/steadymap/v1/ingest_service.proto.
class IngestService final : public v1::IngestService::CallbackService {
 public:
  explicit IngestService(const UploadStream::Surroundings& surroundings)
      : surroundings_(surroundings) {}

  UploadStream::GrpcReactor* UploadFrames(grpc::CallbackServerContext* context) override;

  grpc::ServerUnaryReactor* UploadFrameBatch(grpc::CallbackServerContext* context,
                                             const v1::UploadFrameBatchRequest* request,
                                             v1::UploadFrameBatchResponse* response) override;

  grpc::ServerUnaryReactor* GetUploadState(grpc::CallbackServerContext* context,
                                           const v1::GetUploadStateRequest* request,
                                           v1::UploadState* response) override;

 private:
  const UploadStream::Surroundings surroundings_;
};

}  // namespace steadymap
