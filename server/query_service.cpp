#include "server/query_service.h"

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "server/object_answers.h"
#include "server/pool_call.h"
#include "server/query_answers.h"
#include "server/query_selection.h"

namespace steadymap {
namespace {

using Surroundings = QueryService::Surroundings;

using FoundMap = absl::StatusOr<std::shared_ptr<MapRuntime>>;

/// Calls `go_on` once the map is open, or at once if there is none.
void WaitUntilOpened(const FoundMap& map, std::function<void()> go_on) {
  if (map.ok()) return (*map)->WhenOpened(std::move(go_on));
  go_on();
}

/// OK, or why nothing can be read of the map.
absl::Status CheckReads(const FoundMap& map) {
  return map.ok() ? (*map)->CheckReads() : map.status();
}

/// The map that a request calls `name` in its field `field`.
template <typename Request>
FoundMap FindMap(const Surroundings& surroundings,
                 const Request& request,
                 const std::string& name,
                 std::string_view field) {
  if (request.has_as_of()) return AsOfError();
  return surroundings.maps->Find(name, field);
}

/// Answers with what `answer` makes of a map, once that is open.
template <typename Answer>
grpc::ServerUnaryReactor* AnswerOfMap(const Surroundings& surroundings,
                                      const FoundMap& map,
                                      const Answer& answer) {
  return AnswerOnPoolAfter(
      [&map](std::function<void()> go_on) { WaitUntilOpened(map, std::move(go_on)); },
      surroundings.readers,
      [map, answer](const Cancellation& cancellation) {
        const absl::Status status = CheckReads(map);
        return status.ok() ? answer(**map, cancellation) : status;
      });
}

/// The same for the map that the request names in its field `map`.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerOfMap(const Surroundings& surroundings,
                                      const Request* request,
                                      const Answer& answer) {
  return AnswerOfMap(surroundings, FindMap(surroundings, *request, request->map(), "map"), answer);
}

/// Answers with the messages of the source that `open` makes of the map that the request names.
template <typename Response, typename Request, typename Open>
grpc::ServerWriteReactor<Response>* StreamOfMap(const Surroundings& surroundings,
                                                grpc::CallbackServerContext* context,
                                                const Request* request,
                                                const Open& open) {
  using Stream = MessageStream<Response>;
  const FoundMap map = FindMap(surroundings, *request, request->map(), "map");
  return Stream::Start(
      {surroundings.readers, surroundings.streams},
      context,
      [&map](std::function<void()> go_on) { WaitUntilOpened(map, std::move(go_on)); },
      [map, request, open](const Cancellation& cancellation)
          -> absl::StatusOr<std::unique_ptr<typename Stream::Source>> {
        if (absl::Status status = CheckReads(map); !status.ok()) return status;
        return open((*map)->snapshot(), *request, cancellation);
      });
}

}  // namespace

grpc::ServerUnaryReactor* QueryService::GetObject(grpc::CallbackServerContext* /*context*/,
                                                  const v1::GetObjectRequest* request,
                                                  v1::GetObjectResponse* response) {
  const absl::StatusOr<ObjectName> name = ReadObjectName(*request);
  const FoundMap map = name.ok() ? FindMap(surroundings_, *request, name->map, name->map_field)
                                 : FoundMap(name.status());
  return AnswerOfMap(
      surroundings_, map, [name, response](const MapRuntime& found, const Cancellation&) {
        return AnswerGetObject(*found.snapshot(), *name, response);
      });
}

grpc::ServerUnaryReactor* QueryService::ListObjects(grpc::CallbackServerContext* /*context*/,
                                                    const v1::ListObjectsRequest* request,
                                                    v1::ListObjectsResponse* response) {
  return AnswerOfMap(surroundings_,
                     request,
                     [request, response](const MapRuntime& map, const Cancellation& cancellation) {
                       return AnswerListObjects(
                           map.key(), *map.snapshot(), *request, cancellation, response);
                     });
}

grpc::ServerUnaryReactor* QueryService::ListEvents(grpc::CallbackServerContext* /*context*/,
                                                   const v1::ListEventsRequest* request,
                                                   v1::ListEventsResponse* response) {
  return AnswerOfMap(
      surroundings_,
      request,
      [this, request, response](const MapRuntime& map, const Cancellation& cancellation) {
        return AnswerListEvents(
            *surroundings_.store, map.key(), *map.snapshot(), *request, cancellation, response);
      });
}

grpc::ServerUnaryReactor* QueryService::SampleDistance(grpc::CallbackServerContext* /*context*/,
                                                       const v1::SampleDistanceRequest* request,
                                                       v1::SampleDistanceResponse* response) {
  return AnswerOfMap(surroundings_,
                     request,
                     [request, response](const MapRuntime& map, const Cancellation& cancellation) {
                       return AnswerSampleDistance(
                           *map.snapshot(), *request, cancellation, response);
                     });
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* /*context*/,
                                                 const v1::CastRaysRequest* request,
                                                 v1::CastRaysResponse* response) {
  return AnswerOfMap(surroundings_,
                     request,
                     [request, response](const MapRuntime& map, const Cancellation& cancellation) {
                       return AnswerCastRays(*map.snapshot(), *request, cancellation, response);
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

grpc::ServerUnaryReactor* QueryService::ListFramePoses(grpc::CallbackServerContext* /*context*/,
                                                       const v1::ListFramePosesRequest* request,
                                                       v1::ListFramePosesResponse* response) {
  return AnswerOfMap(
      surroundings_,
      request,
      [this, request, response](const MapRuntime& map, const Cancellation& cancellation) {
        return AnswerListFramePoses(
            *surroundings_.store, map.key(), *map.snapshot(), *request, cancellation, response);
      });
}

}  // namespace steadymap
