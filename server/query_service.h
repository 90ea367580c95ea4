#pragma once

#include "server/map_directory.h"
#include "server/store.h"
#include "server/stream_gate.h"
#include "server/worker_pool.h"

#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {

/// Reads maps; see proto/steadymap/v1/query_service.proto. Every call works on the one snapshot
/// that it took at its start, on a pool of its own, so queries never hold up uploads.
class QueryService final : public v1::QueryService::CallbackService {
 public:
  /// What the service needs of the server; all of it outlives it.
  struct Surroundings {
    MapDirectory* maps = nullptr;
    Store* store = nullptr;
    WorkerPool* readers = nullptr;
    StreamGate* streams = nullptr;  ///< Of exports and sections.
  };

  explicit QueryService(const Surroundings& surroundings) : surroundings_(surroundings) {}

  grpc::ServerUnaryReactor* GetObject(grpc::CallbackServerContext* context,
                                      const v1::GetObjectRequest* request,
                                      v1::GetObjectResponse* response) override;
  grpc::ServerUnaryReactor* ListObjects(grpc::CallbackServerContext* context,
                                        const v1::ListObjectsRequest* request,
                                        v1::ListObjectsResponse* response) override;
  grpc::ServerUnaryReactor* ListEvents(grpc::CallbackServerContext* context,
                                       const v1::ListEventsRequest* request,
                                       v1::ListEventsResponse* response) override;
  grpc::ServerUnaryReactor* SampleDistance(grpc::CallbackServerContext* context,
                                           const v1::SampleDistanceRequest* request,
                                           v1::SampleDistanceResponse* response) override;
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* response) override;
  grpc::ServerWriteReactor<v1::GetMapSectionResponse>* GetMapSection(
      grpc::CallbackServerContext* context, const v1::GetMapSectionRequest* request) override;
  grpc::ServerWriteReactor<v1::ExportMapResponse>* ExportMap(
      grpc::CallbackServerContext* context, const v1::ExportMapRequest* request) override;
  grpc::ServerUnaryReactor* ListFramePoses(grpc::CallbackServerContext* context,
                                           const v1::ListFramePosesRequest* request,
                                           v1::ListFramePosesResponse* response) override;

 private:
  const Surroundings surroundings_;
};

}  // namespace steadymap
