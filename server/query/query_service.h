#pragma once

#include "server/mapping/map_directory.h"
#include "server/process/worker_pool.h"
#include "server/rpc/stream_limiter.h"
#include "server/store/model/store.h"

#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {

/// The generated service, with messages as bytes.
using RawQueryService = v1::QueryService::WithRawCallbackMethod_GetObject<
    v1::QueryService::WithRawCallbackMethod_ListObjects<
        v1::QueryService::WithRawCallbackMethod_ListEvents<
            v1::QueryService::WithRawCallbackMethod_SampleDistance<
                v1::QueryService::WithRawCallbackMethod_CastRays<
                    v1::QueryService::WithRawCallbackMethod_GetMapSection<
                        v1::QueryService::WithRawCallbackMethod_ExportMap<
                            v1::QueryService::WithRawCallbackMethod_ListFramePoses<
                                v1::QueryService::WithRawCallbackMethod_ListRobots<
                                    v1::QueryService::Service>>>>>>>>>;

/// The query service for maps; see proto/steadymap/v1/query_service.proto. Each call uses the
/// snapshot that was current at its start, and runs on the pool `readers`, so that queries do not
/// delay uploads.
class QueryService final : public RawQueryService {
 public:
  /// The parts of the server that the service uses. All of them must outlive it.
  struct Dependencies {
    MapDirectory* maps = nullptr;
    Store* store = nullptr;
    WorkerPool* readers = nullptr;
    StreamLimiter* streams = nullptr;  ///< Limits exports and sections.
  };

  explicit QueryService(const Dependencies& dependencies) : dependencies_(dependencies) {}

  grpc::ServerUnaryReactor* GetObject(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListObjects(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListEvents(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* SampleDistance(grpc::CallbackServerContext* context,
                                           const grpc::ByteBuffer* request,
                                           grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* GetMapSection(
      grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* ExportMap(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request) override;
  grpc::ServerUnaryReactor* ListFramePoses(grpc::CallbackServerContext* context,
                                           const grpc::ByteBuffer* request,
                                           grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListRobots(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;

 private:
  const Dependencies dependencies_;
};

}  // namespace steadymap
