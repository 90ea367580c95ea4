#include "server/query/query_service.h"

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "server/query/event_responses.h"
#include "server/query/map_export.h"
#include "server/query/map_section.h"
#include "server/query/object_responses.h"
#include "server/query/query_responses.h"
#include "server/query/query_selection.h"
#include "server/rpc/message_call.h"
#include "server/rpc/pool_call.h"

namespace steadymap {
namespace {

using Dependencies = QueryService::Dependencies;

using FoundMap = absl::StatusOr<std::shared_ptr<MapRuntime>>;

/// Calls `resume` once the map is open, or immediately if the map was not found.
void WaitUntilOpened(const FoundMap& map, std::function<void()> resume) {
  if (map.ok()) return (*map)->WhenOpened(std::move(resume));
  resume();
}

/// Returns OK, or the reason for which the map cannot be read.
absl::Status CheckReads(const FoundMap& map) {
  return map.ok() ? (*map)->CheckReads() : map.status();
}

/// Finds the map `name`, from the field `field` of the request.
template <typename Request>
FoundMap FindMap(const Dependencies& dependencies,
                 const Request& request,
                 const std::string& name,
                 std::string_view field) {
  if (request.has_as_of()) return AsOfError();
  return dependencies.maps->Find(name, field);
}

/// Calls `answer` with a map and a call on the pool, once the map is open, and finishes the call
/// with its status.
template <typename Call, typename Answer>
grpc::ServerUnaryReactor* AnswerFromMap(const Dependencies& dependencies,
                                        const FoundMap& map,
                                        const Call& call,
                                        const Answer& answer) {
  return AnswerOnPoolAfter(
      [&map](std::function<void()> resume) { WaitUntilOpened(map, std::move(resume)); },
      dependencies.readers,
      [map, call, answer](const Cancellation& cancellation) {
        const absl::Status status = CheckReads(map);
        return call.Answer(status.ok() ? answer(**map, call, cancellation) : status);
      });
}

/// Parses a request that names the map in its field `map`, and answers it with `answer` once the
/// map is open.
template <typename Request, typename Response, typename Answer>
grpc::ServerUnaryReactor* AnswerFromMap(const Dependencies& dependencies,
                                        const grpc::ByteBuffer& request,
                                        grpc::ByteBuffer* response,
                                        const RequestLimits& limits,
                                        const Answer& answer) {
  return StartMessageCall<Request, Response>(
      request, response, limits, [&dependencies, &answer](const auto& call) {
        const Request& message = call.request();
        return AnswerFromMap(
            dependencies, FindMap(dependencies, message, message.map(), "map"), call, answer);
      });
}

/// Streams the messages of the source that `open` makes of the requested map, once the map is open.
template <typename Request, typename Response, typename Open>
grpc::ServerWriteReactor<grpc::ByteBuffer>* StreamFromMap(const Dependencies& dependencies,
                                                          grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer& bytes,
                                                          const Open& open) {
  using Stream = MessageStream<Response>;
  const auto request = std::make_shared<Request>();
  const absl::Status read = ReadRequest(bytes, kPlainRequestLimits, request.get());
  const FoundMap map =
      read.ok() ? FindMap(dependencies, *request, request->map(), "map") : FoundMap(read);
  return Stream::Start(
      {dependencies.readers, dependencies.streams},
      context,
      [&map](std::function<void()> resume) { WaitUntilOpened(map, std::move(resume)); },
      [map, request, open](const Cancellation& cancellation)
          -> absl::StatusOr<std::unique_ptr<typename Stream::Source>> {
        if (absl::Status status = CheckReads(map); !status.ok()) return status;
        return open((*map)->snapshot(), *request, cancellation);
      });
}

}  // namespace

grpc::ServerUnaryReactor* QueryService::GetObject(grpc::CallbackServerContext* /*context*/,
                                                  const grpc::ByteBuffer* request,
                                                  grpc::ByteBuffer* response) {
  return StartMessageCall<v1::GetObjectRequest, v1::GetObjectResponse>(
      *request, response, kPlainRequestLimits, [this](const auto& call) {
        const absl::StatusOr<ObjectName> name = ReadObjectName(call.request());
        const FoundMap map =
            name.ok() ? FindMap(dependencies_, call.request(), name->map, name->map_field)
                      : FoundMap(name.status());
        return AnswerFromMap(
            dependencies_,
            map,
            call,
            [name](const MapRuntime& found, const auto& answered, const Cancellation&) {
              return AnswerGetObject(*found.snapshot(), *name, answered.response());
            });
      });
}

grpc::ServerUnaryReactor* QueryService::ListObjects(grpc::CallbackServerContext* /*context*/,
                                                    const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  return AnswerFromMap<v1::ListObjectsRequest, v1::ListObjectsResponse>(
      dependencies_,
      *request,
      response,
      kPlainRequestLimits,
      [](const MapRuntime& map, const auto& call, const Cancellation& cancellation) {
        return AnswerListObjects(
            map.key(), *map.snapshot(), call.request(), cancellation, call.response());
      });
}

grpc::ServerUnaryReactor* QueryService::ListEvents(grpc::CallbackServerContext* /*context*/,
                                                   const grpc::ByteBuffer* request,
                                                   grpc::ByteBuffer* response) {
  return AnswerFromMap<v1::ListEventsRequest, v1::ListEventsResponse>(
      dependencies_,
      *request,
      response,
      kPlainRequestLimits,
      [this](const MapRuntime& map, const auto& call, const Cancellation& cancellation) {
        return AnswerListEvents(*dependencies_.store,
                                map.key(),
                                *map.snapshot(),
                                call.request(),
                                cancellation,
                                call.response());
      });
}

grpc::ServerUnaryReactor* QueryService::SampleDistance(grpc::CallbackServerContext* /*context*/,
                                                       const grpc::ByteBuffer* request,
                                                       grpc::ByteBuffer* response) {
  return AnswerFromMap<v1::SampleDistanceRequest, v1::SampleDistanceResponse>(
      dependencies_,
      *request,
      response,
      kPointRequestLimits,
      [](const MapRuntime& map, const auto& call, const Cancellation& cancellation) {
        return AnswerSampleDistance(*map.snapshot(), call.request(), cancellation, call.response());
      });
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* /*context*/,
                                                 const grpc::ByteBuffer* request,
                                                 grpc::ByteBuffer* response) {
  return AnswerFromMap<v1::CastRaysRequest, v1::CastRaysResponse>(
      dependencies_,
      *request,
      response,
      kPointRequestLimits,
      [](const MapRuntime& map, const auto& call, const Cancellation& cancellation) {
        return AnswerCastRays(*map.snapshot(), call.request(), cancellation, call.response());
      });
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* QueryService::GetMapSection(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return StreamFromMap<v1::GetMapSectionRequest, v1::GetMapSectionResponse>(
      dependencies_, context, *request, OpenMapSection);
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* QueryService::ExportMap(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return StreamFromMap<v1::ExportMapRequest, v1::ExportMapResponse>(
      dependencies_, context, *request, OpenExport);
}

grpc::ServerUnaryReactor* QueryService::ListFramePoses(grpc::CallbackServerContext* /*context*/,
                                                       const grpc::ByteBuffer* request,
                                                       grpc::ByteBuffer* response) {
  return AnswerFromMap<v1::ListFramePosesRequest, v1::ListFramePosesResponse>(
      dependencies_,
      *request,
      response,
      kPlainRequestLimits,
      [this](const MapRuntime& map, const auto& call, const Cancellation& cancellation) {
        return AnswerListFramePoses(*dependencies_.store,
                                    map.key(),
                                    *map.snapshot(),
                                    call.request(),
                                    cancellation,
                                    call.response());
      });
}

grpc::ServerUnaryReactor* QueryService::ListRobots(grpc::CallbackServerContext* /*context*/,
                                                   const grpc::ByteBuffer* request,
                                                   grpc::ByteBuffer* response) {
  return AnswerFromMap<v1::ListRobotsRequest, v1::ListRobotsResponse>(
      dependencies_,
      *request,
      response,
      kPlainRequestLimits,
      [](const MapRuntime& map, const auto& call, const Cancellation&) {
        return AnswerListRobots(*map.snapshot(), call.response());
      });
}

}  // namespace steadymap
