#pragma once

#include <deque>
#include <string>

#include "server/config/server_config.h"
#include "server/mapping/map_directory.h"
#include "server/process/worker_pool.h"
#include "server/rpc/pool_call.h"
#include "server/store/database/writer_mutex.h"
#include "server/upload/upload_registry.h"
#include "server/watch/watch_hub.h"

#include "steadymap/v1/map_service.grpc.pb.h"

namespace steadymap {

/// The generated service, with messages as bytes.
using RawMapService = v1::MapService::WithRawCallbackMethod_CreateMap<
    v1::MapService::WithRawCallbackMethod_GetMap<v1::MapService::WithRawCallbackMethod_ListMaps<
        v1::MapService::WithRawCallbackMethod_UpdateMap<
            v1::MapService::WithRawCallbackMethod_DeleteMap<v1::MapService::Service>>>>>;

/// The service for creating, listing, updating and deleting maps; see
/// proto/steadymap/v1/map_service.proto.
class MapService final : public RawMapService {
 public:
  /// The parts of the server that the service uses. All of them must outlive it.
  struct Dependencies {
    MapDirectory* maps = nullptr;
    UploadRegistry* registry = nullptr;
    WatchHub* watches = nullptr;
    WorkerPool* pool = nullptr;
    RetentionOptions retention;
  };

  explicit MapService(const Dependencies& dependencies) : dependencies_(dependencies) {}

  grpc::ServerUnaryReactor* CreateMap(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetMap(grpc::CallbackServerContext* context,
                                   const grpc::ByteBuffer* request,
                                   grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListMaps(grpc::CallbackServerContext* context,
                                     const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* UpdateMap(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* DeleteMap(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;

 private:
  /// A deletion that a client may request again.
  struct Deletion {
    MapName name;
    std::string request_id;

    friend bool operator==(const Deletion&, const Deletion&) = default;
  };

  void Create(const v1::CreateMapRequest& request, v1::Map* response, const FinishCall& finish);
  absl::Status List(const v1::ListMapsRequest& request, v1::ListMapsResponse* response);
  absl::Status Update(const v1::UpdateMapRequest& request, v1::Map* response);
  absl::Status AddClasses(const v1::UpdateMapRequest& request, MapRuntime* map);
  absl::Status Delete(const v1::DeleteMapRequest& request);

  const Dependencies dependencies_;
  WriterMutex changes_;             ///< Serialises creation, update and deletion of maps.
  std::deque<Deletion> deletions_;  ///< Recent ones, oldest first. Guarded by `changes_`.
};

}  // namespace steadymap
