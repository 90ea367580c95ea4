#include "server/query_service.h"

#include "core/error.h"
#include "server/object_answers.h"
#include "server/pool_call.h"
#include "server/query_answers.h"

namespace steadymap {
namespace {

// An export holds its whole file: so many at once, the rest comes again later.
constexpr std::size_t kMaxStreams = 16;

}  // namespace

grpc::ServerUnaryReactor* QueryService::GetObject(grpc::CallbackServerContext* context,
                                                  const v1::GetObjectRequest* request,
                                                  v1::GetObjectResponse* response) {
  return AnswerOnPool(surroundings_.readers, context, [this, request, response] {
    const auto map = surroundings_.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return AnswerGetObject(*(*map)->snapshot(), *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::ListObjects(grpc::CallbackServerContext* context,
                                                    const v1::ListObjectsRequest* request,
                                                    v1::ListObjectsResponse* response) {
  return AnswerOnPool(surroundings_.readers, context, [this, request, response] {
    const auto map = surroundings_.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return AnswerListObjects((*map)->key(), *(*map)->snapshot(), *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::ListEvents(grpc::CallbackServerContext* context,
                                                   const v1::ListEventsRequest* request,
                                                   v1::ListEventsResponse* response) {
  return AnswerOnPool(surroundings_.readers, context, [this, request, response] {
    const auto map = surroundings_.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return AnswerListEvents(
        *surroundings_.store, (*map)->key(), (*map)->snapshot()->revision, *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::SampleDistance(grpc::CallbackServerContext* context,
                                                       const v1::SampleDistanceRequest* request,
                                                       v1::SampleDistanceResponse* response) {
  return AnswerOnPool(surroundings_.readers, context, [this, request, response] {
    const auto map = surroundings_.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return AnswerSampleDistance(*(*map)->snapshot(), *request, response);
  });
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* context,
                                                 const v1::CastRaysRequest* request,
                                                 v1::CastRaysResponse* response) {
  return AnswerOnPool(surroundings_.readers, context, [this, request, response] {
    const auto map = surroundings_.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return AnswerCastRays(*(*map)->snapshot(), *request, response);
  });
}

grpc::ServerWriteReactor<v1::GetMapSectionResponse>* QueryService::GetMapSection(
    grpc::CallbackServerContext* /*context*/, const v1::GetMapSectionRequest* request) {
  using Stream = MessageStream<v1::GetMapSectionResponse>;
  const absl::Status entered = EnterStream();
  return Stream::Start(
      surroundings_.readers,
      [this, request, entered]() -> absl::StatusOr<std::unique_ptr<Stream::Source>> {
        if (!entered.ok()) return entered;
        const auto map = surroundings_.maps->Find(request->map(), "map");
        if (!map.ok()) return map.status();
        return OpenMapSection((*map)->snapshot(), *request);
      },
      [this] { --streams_; });
}

grpc::ServerWriteReactor<v1::ExportMapResponse>* QueryService::ExportMap(
    grpc::CallbackServerContext* /*context*/, const v1::ExportMapRequest* request) {
  using Stream = MessageStream<v1::ExportMapResponse>;
  const absl::Status entered = EnterStream();
  return Stream::Start(
      surroundings_.readers,
      [this, request, entered]() -> absl::StatusOr<std::unique_ptr<Stream::Source>> {
        if (!entered.ok()) return entered;
        const auto map = surroundings_.maps->Find(request->map(), "map");
        if (!map.ok()) return map.status();
        return OpenExport(*(*map)->snapshot(), *request);
      },
      [this] { --streams_; });
}

grpc::ServerUnaryReactor* QueryService::ListFramePoses(grpc::CallbackServerContext* context,
                                                       const v1::ListFramePosesRequest* request,
                                                       v1::ListFramePosesResponse* response) {
  return AnswerOnPool(surroundings_.readers, context, [this, request, response] {
    const auto map = surroundings_.maps->Find(request->map(), "map");
    if (!map.ok()) return map.status();
    return AnswerListFramePoses(*surroundings_.store, **map, *request, response);
  });
}

/// Counts a stream, in any case until its end.
absl::Status QueryService::EnterStream() {
  return ++streams_ <= kMaxStreams ? absl::OkStatus() : PoolFullError();
}

}  // namespace steadymap
