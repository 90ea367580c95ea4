#include "server/query_service.h"

#include <functional>
#include <memory>
#include <utility>

#include "server/object_answers.h"
#include "server/pool_call.h"
#include "server/query_answers.h"

namespace steadymap {
namespace {

// An export holds its whole file: so many at once, the rest comes again later.
constexpr std::size_t kMaxStreams = 16;

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

/// Answers with what `answer` makes of the map that the request names, once that is open.
template <typename Request, typename Answer>
grpc::ServerUnaryReactor* AnswerOfMap(const Surroundings& surroundings,
                                      const Request* request,
                                      const Answer& answer) {
  const FoundMap map = surroundings.maps->Find(request->map(), "map");
  return AnswerOnPoolAfter(
      [&map](std::function<void()> go_on) { WaitUntilOpened(map, std::move(go_on)); },
      surroundings.readers,
      [map, answer](const Cancellation& cancellation) {
        const absl::Status status = CheckReads(map);
        return status.ok() ? answer(**map, cancellation) : status;
      });
}

/// Starts the stream that `open` makes of the map that the request names, if it may enter; calls
/// `leave` in any case at its end.
template <typename Response, typename Request, typename Open>
grpc::ServerWriteReactor<Response>* StreamOfMap(const Surroundings& surroundings,
                                                const Request* request,
                                                const absl::Status& entered,
                                                const Open& open,
                                                std::function<void()> leave) {
  using Stream = MessageStream<Response>;
  const FoundMap map = surroundings.maps->Find(request->map(), "map");
  return Stream::Start(
      [&map](std::function<void()> go_on) { WaitUntilOpened(map, std::move(go_on)); },
      surroundings.readers,
      [map, entered, open]() -> absl::StatusOr<std::unique_ptr<typename Stream::Source>> {
        if (!entered.ok()) return entered;
        if (absl::Status status = CheckReads(map); !status.ok()) return status;
        return open(**map);
      },
      std::move(leave));
}

}  // namespace

grpc::ServerUnaryReactor* QueryService::GetObject(grpc::CallbackServerContext* /*context*/,
                                                  const v1::GetObjectRequest* request,
                                                  v1::GetObjectResponse* response) {
  return AnswerOfMap(
      surroundings_, request, [request, response](const MapRuntime& map, const Cancellation&) {
        return AnswerGetObject(*map.snapshot(), *request, response);
      });
}

grpc::ServerUnaryReactor* QueryService::ListObjects(grpc::CallbackServerContext* /*context*/,
                                                    const v1::ListObjectsRequest* request,
                                                    v1::ListObjectsResponse* response) {
  return AnswerOfMap(
      surroundings_, request, [request, response](const MapRuntime& map, const Cancellation&) {
        return AnswerListObjects(map.key(), *map.snapshot(), *request, response);
      });
}

grpc::ServerUnaryReactor* QueryService::ListEvents(grpc::CallbackServerContext* /*context*/,
                                                   const v1::ListEventsRequest* request,
                                                   v1::ListEventsResponse* response) {
  return AnswerOfMap(
      surroundings_,
      request,
      [this, request, response](const MapRuntime& map, const Cancellation&) {
        return AnswerListEvents(
            *surroundings_.store, map.key(), map.snapshot()->revision, *request, response);
      });
}

grpc::ServerUnaryReactor* QueryService::SampleDistance(grpc::CallbackServerContext* /*context*/,
                                                       const v1::SampleDistanceRequest* request,
                                                       v1::SampleDistanceResponse* response) {
  return AnswerOfMap(
      surroundings_, request, [request, response](const MapRuntime& map, const Cancellation&) {
        return AnswerSampleDistance(*map.snapshot(), *request, response);
      });
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* /*context*/,
                                                 const v1::CastRaysRequest* request,
                                                 v1::CastRaysResponse* response) {
  return AnswerOfMap(
      surroundings_, request, [request, response](const MapRuntime& map, const Cancellation&) {
        return AnswerCastRays(*map.snapshot(), *request, response);
      });
}

grpc::ServerWriteReactor<v1::GetMapSectionResponse>* QueryService::GetMapSection(
    grpc::CallbackServerContext* /*context*/, const v1::GetMapSectionRequest* request) {
  return StreamOfMap<v1::GetMapSectionResponse>(
      surroundings_,
      request,
      EnterStream(),
      [request](const MapRuntime& map) { return OpenMapSection(map.snapshot(), *request); },
      [this] { --streams_; });
}

grpc::ServerWriteReactor<v1::ExportMapResponse>* QueryService::ExportMap(
    grpc::CallbackServerContext* /*context*/, const v1::ExportMapRequest* request) {
  return StreamOfMap<v1::ExportMapResponse>(
      surroundings_,
      request,
      EnterStream(),
      [request](const MapRuntime& map) { return OpenExport(*map.snapshot(), *request); },
      [this] { --streams_; });
}

grpc::ServerUnaryReactor* QueryService::ListFramePoses(grpc::CallbackServerContext* /*context*/,
                                                       const v1::ListFramePosesRequest* request,
                                                       v1::ListFramePosesResponse* response) {
  return AnswerOfMap(surroundings_,
                     request,
                     [this, request, response](const MapRuntime& map, const Cancellation&) {
                       return AnswerListFramePoses(*surroundings_.store, map, *request, response);
                     });
}

/// Counts a stream, in any case until its end.
absl::Status QueryService::EnterStream() {
  return ++streams_ <= kMaxStreams ? absl::OkStatus() : PoolFullError();
}

}  // namespace steadymap
