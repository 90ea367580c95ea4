#pragma once

#include "server/upload/upload_stream.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"

namespace steadymap {

/// Receives frames from robots; see proto/steadymap/v1/ingest_service.proto. Receives requests as
/// bytes, so that their size is checked before they are parsed.
class IngestService final : public v1::IngestService::WithRawCallbackMethod_UploadFrames<
                                v1::IngestService::WithRawCallbackMethod_UploadFrameBatch<
                                    v1::IngestService::WithRawCallbackMethod_GetUploadState<
                                        v1::IngestService::Service>>> {
 public:
  explicit IngestService(const UploadStream::Dependencies& dependencies)
      : dependencies_(dependencies) {}

  UploadStream::GrpcReactor* UploadFrames(grpc::CallbackServerContext* context) override;

  grpc::ServerUnaryReactor* UploadFrameBatch(grpc::CallbackServerContext* context,
                                             const grpc::ByteBuffer* request,
                                             grpc::ByteBuffer* response) override;

  grpc::ServerUnaryReactor* GetUploadState(grpc::CallbackServerContext* context,
                                           const grpc::ByteBuffer* request,
                                           grpc::ByteBuffer* response) override;

 private:
  const UploadStream::Dependencies dependencies_;
};

}  // namespace steadymap
