#include "server/query_service.h"

#include <memory>
#include <utility>

#include "server/object_answers.h"
#include "server/pool_call.h"
#include "server/query_answers.h"

namespace steadymap {
namespace {

using Surroundings = QueryService::Surroundings;

/// Answers with what `answer` makes of the map that the request names.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerOfMap(const Surroundings& surroundings,
                                      grpc::CallbackServerContext* context,
                                      const Request* request,
                                      const Answer& answer) {
  return AnswerOnPool(surroundings.readers, context, [&surroundings, request, answer] {
    const auto map = surroundings.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return answer(**map);
  });
}

/// Answers with the messages of the source that `open` makes of the map that the request names.
template <typename Response, typename Request, typename Open>
grpc::ServerWriteReactor<Response>* StreamOfMap(const Surroundings& surroundings,
                                                grpc::CallbackServerContext* context,
                                                const Request* request,
                                                const Open& open) {
  using Stream = MessageStream<Response>;
  return Stream::Start({surroundings.readers, surroundings.streams},
                       context,
                       [&surroundings, request, open](CancelCheck check)
                           -> absl::StatusOr<std::unique_ptr<typename Stream::Source>> {
                         const auto map = surroundings.maps->Find(request->map(), "map");
                         if (!map.ok()) return map.status();
                         return open((*map)->snapshot(), *request, std::move(check));
                       });
}

}  // namespace

grpc::ServerUnaryReactor* QueryService::GetObject(grpc::CallbackServerContext* context,
                                                  const v1::GetObjectRequest* request,
                                                  v1::GetObjectResponse* response) {
  return AnswerOfMap(surroundings_, context, request, [request, response](const MapRuntime& map) {
    return AnswerGetObject(*map.snapshot(), *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::ListObjects(grpc::CallbackServerContext* context,
                                                    const v1::ListObjectsRequest* request,
                                                    v1::ListObjectsResponse* response) {
  return AnswerOfMap(surroundings_, context, request, [request, response](const MapRuntime& map) {
    return AnswerListObjects(map.key(), *map.snapshot(), *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::ListEvents(grpc::CallbackServerContext* context,
                                                   const v1::ListEventsRequest* request,
                                                   v1::ListEventsResponse* response) {
  return AnswerOfMap(
      surroundings_, context, request, [this, request, response](const MapRuntime& map) {
        return AnswerListEvents(
            *surroundings_.store, map.key(), map.snapshot()->revision, *request, response);
      });
}

grpc::ServerUnaryReactor* QueryService::SampleDistance(grpc::CallbackServerContext* context,
                                                       const v1::SampleDistanceRequest* request,
                                                       v1::SampleDistanceResponse* response) {
  return AnswerOfMap(surroundings_, context, request, [request, response](const MapRuntime& map) {
    return AnswerSampleDistance(*map.snapshot(), *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* context,
                                                 const v1::CastRaysRequest* request,
                                                 v1::CastRaysResponse* response) {
  return AnswerOfMap(surroundings_, context, request, [request, response](const MapRuntime& map) {
    return AnswerCastRays(*map.snapshot(), *request, response);
  });
}

grpc::ServerWriteReactor<v1::GetMapSectionResponse>* QueryService::GetMapSection(
    grpc::CallbackServerContext* context, const v1::GetMapSectionRequest* request) {
  return StreamOfMap<v1::GetMapSectionResponse>(surroundings_, context, request, OpenMapSection);
}

grpc::ServerWriteReactor<v1::ExportMapResponse>* QueryService::ExportMap(
    grpc::CallbackServerContext* context, const v1::ExportMapRequest* request) {
  return StreamOfMap<v1::ExportMapResponse>(surroundings_, context, request, OpenExport);
}

grpc::ServerUnaryReactor* QueryService::ListFramePoses(grpc::CallbackServerContext* context,
                                                       const v1::ListFramePosesRequest* request,
                                                       v1::ListFramePosesResponse* response) {
  return AnswerOfMap(
      surroundings_, context, request, [this, request, response](const MapRuntime& map) {
        return AnswerListFramePoses(*surroundings_.store, map, *request, response);
      });
}

}  // namespace steadymap
