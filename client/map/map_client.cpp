#include "client/map/map_client.h"

#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include <absl/strings/str_cat.h>
#include <google/protobuf/util/time_util.h>
#include <grpcpp/client_context.h>

#include "client/map/map_section_reader.h"
#include "client/transport/protocol_error.h"
#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "proto/convert_geometry.h"
#include "proto/grpc_status.h"

namespace steadymap {
namespace {

using MapStub = v1::MapService::StubInterface;
using QueryStub = v1::QueryService::StubInterface;

constexpr std::uint32_t kMapsPerPage = 1000;
constexpr std::uint32_t kPosesPerPage = 10'000;
constexpr std::uint32_t kObjectsPerPage = 1000;
constexpr std::uint32_t kEventsPerPage = 10'000;

// Makes a unary call.
template <typename Stub, typename Request, typename Response>
absl::StatusOr<Response> Call(Stub* stub,
                              grpc::Status (Stub::*method)(grpc::ClientContext*,
                                                           const Request&,
                                                           Response*),
                              const Request& request,
                              std::chrono::milliseconds timeout) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + timeout);
  Response response;
  const grpc::Status status = (stub->*method)(&context, request, &response);
  if (!status.ok()) return FromGrpcStatus(status);
  return response;
}

void SetTimeout(grpc::ClientContext* context, std::chrono::milliseconds timeout) {
  context->set_deadline(std::chrono::system_clock::now() + timeout);
}

template <typename Request>
void Select(const VolumeSelection& selection, Request* request) {
  if (selection.box_world) *request->mutable_box() = ToProto(*selection.box_world);
  for (const ObjectId object : selection.objects) request->add_object_ids(object.value());
}

absl::Status DamagedExport(const std::string& what) {
  return MakeError(absl::StatusCode::kDataLoss, reason::kChecksum, what);
}

// Receives a file from an export stream.
class ExportReader {
 public:
  explicit ExportReader(const MapClient::ChunkSink& sink) : sink_(sink) {}

  absl::Status Take(const v1::ExportMapResponse& message) {
    if (trailer_) return ProtocolError("the server sent data after the trailer of a file");
    if (message.has_header() == header_.has_value()) {
      return ProtocolError("the server sent a file that does not begin with one header");
    }
    if (message.has_header()) {
      header_ = message.header();
    } else if (message.has_trailer()) {
      trailer_ = message.trailer();
    } else if (message.has_chunk()) {
      received_bytes_ += message.chunk().size();
      received_crc32c_ = ExtendCrc32c(received_crc32c_, message.chunk());
      return sink_(message.chunk());
    }
    return absl::OkStatus();
  }

  // Called after the stream ended with OK.
  absl::StatusOr<ExportSummary> Finish() const {
    if (!trailer_) {
      return DamagedExport(
          absl::StrCat("the file is incomplete: ", received_bytes_, " bytes received, no trailer"));
    }
    if (trailer_->file_bytes() != received_bytes_) {
      return DamagedExport(absl::StrCat("the file is incomplete: expected ",
                                        trailer_->file_bytes(),
                                        " bytes, received ",
                                        received_bytes_,
                                        " bytes"));
    }
    if (trailer_->crc32c() != received_crc32c_) {
      return DamagedExport("the checksum of the received file differs from the server's");
    }
    return ExportSummary{Revision(header_->revision()), received_bytes_, header_->triangles()};
  }

 private:
  const MapClient::ChunkSink& sink_;
  std::optional<v1::ExportMapResponse::Header> header_;
  std::optional<v1::ExportMapResponse::Trailer> trailer_;
  std::uint64_t received_bytes_ = 0;
  std::uint32_t received_crc32c_ = 0;
};

}  // namespace

MapClient::MapClient(const std::shared_ptr<grpc::ChannelInterface>& channel,
                     const MapClientOptions& options)
    : options_(options),
      maps_(v1::MapService::NewStub(channel)),
      queries_(v1::QueryService::NewStub(channel)) {}

absl::StatusOr<v1::Map> MapClient::CreateMap(const MapName& name,
                                             const v1::MapConfig& config,
                                             const MapSettings& settings) {
  v1::CreateMapRequest request;
  request.set_parent("tenants/" + name.tenant);
  request.set_map_id(name.map);
  v1::Map& map = *request.mutable_map();
  *map.mutable_config() = config;
  if (settings.max_commit_delay.count() > 0) {
    *map.mutable_max_commit_delay() =
        google::protobuf::util::TimeUtil::MillisecondsToDuration(settings.max_commit_delay.count());
  }
  map.mutable_labels()->insert(settings.labels.begin(), settings.labels.end());
  if (settings.world_frame) *map.mutable_world_frame() = *settings.world_frame;
  return Call(maps_.get(), &MapStub::CreateMap, request, options_.call_timeout);
}

absl::StatusOr<v1::Map> MapClient::GetMap(const MapName& name) {
  v1::GetMapRequest request;
  request.set_name(name.ToString());
  return Call(maps_.get(), &MapStub::GetMap, request, options_.call_timeout);
}

absl::StatusOr<std::vector<v1::Map>> MapClient::ListMaps(const std::string& tenant) {
  std::vector<v1::Map> maps;
  v1::ListMapsRequest request;
  request.set_parent("tenants/" + tenant);
  request.set_page_size(kMapsPerPage);
  do {
    auto page = Call(maps_.get(), &MapStub::ListMaps, request, options_.call_timeout);
    if (!page.ok()) return page.status();
    for (v1::Map& map : *page->mutable_maps()) maps.push_back(std::move(map));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return maps;
}

absl::StatusOr<v1::Map> MapClient::UpdateMap(const v1::UpdateMapRequest& request) {
  return Call(maps_.get(), &MapStub::UpdateMap, request, options_.call_timeout);
}

absl::Status MapClient::DeleteMap(const MapName& name) {
  v1::DeleteMapRequest request;
  request.set_name(name.ToString());
  return Call(maps_.get(), &MapStub::DeleteMap, request, options_.call_timeout).status();
}

absl::StatusOr<v1::SampleDistanceResponse> MapClient::SampleDistance(
    const MapName& name, std::span<const Eigen::Vector3d> points_world) {
  v1::SampleDistanceRequest request;
  request.set_map(name.ToString());
  for (const Eigen::Vector3d& point : points_world) *request.add_points_m() = ToProto(point);
  auto response = Call(queries_.get(), &QueryStub::SampleDistance, request, options_.call_timeout);
  if (response.ok() && response->samples_size() != request.points_m_size()) {
    return ProtocolError("the server returned a different number of samples than points");
  }
  return response;
}

absl::StatusOr<v1::CastRaysResponse> MapClient::CastRays(const MapName& name,
                                                         std::span<const WorldRay> rays,
                                                         double max_range_m) {
  v1::CastRaysRequest request;
  request.set_map(name.ToString());
  request.set_max_range_m(max_range_m);
  for (const WorldRay& ray : rays) {
    v1::Ray& message = *request.add_rays();
    *message.mutable_origin_m() = ToProto(ray.origin_world);
    *message.mutable_direction() = ToProto(ray.direction_world);
  }
  auto response = Call(queries_.get(), &QueryStub::CastRays, request, options_.call_timeout);
  if (response.ok() && response->hits_size() != request.rays_size()) {
    return ProtocolError("the server returned a different number of hits than rays");
  }
  return response;
}

absl::StatusOr<v1::Object> MapClient::GetObject(const MapName& name, ObjectId object) {
  v1::GetObjectRequest request;
  request.set_map(name.ToString());
  request.set_object_id(object.value());
  const auto response = Call(queries_.get(), &QueryStub::GetObject, request, options_.call_timeout);
  if (!response.ok()) return response.status();
  return response->object();
}

absl::StatusOr<MapList<v1::Object>> MapClient::ListObjects(const MapName& name,
                                                           const ObjectQuery& query) {
  MapList<v1::Object> list;
  v1::ListObjectsRequest request;
  request.set_map(name.ToString());
  for (const ClassId class_id : query.classes) request.add_class_ids(class_id.value());
  if (query.box_world) *request.mutable_box() = ToProto(*query.box_world);
  request.set_min_stationarity(query.min_stationarity);
  request.set_changed_since(query.changed_since.value());
  request.set_include_archived(query.with_archived_and_tentative);
  request.set_include_tentative(query.with_archived_and_tentative);
  request.set_page_size(kObjectsPerPage);
  do {
    auto page = Call(queries_.get(), &QueryStub::ListObjects, request, options_.call_timeout);
    if (!page.ok()) return page.status();
    list.revision = Revision(page->revision());
    for (v1::Object& object : *page->mutable_objects()) list.entries.push_back(std::move(object));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return list;
}

absl::StatusOr<MapList<v1::ObjectEvent>> MapClient::ListEvents(const MapName& name,
                                                               const EventQuery& query) {
  MapList<v1::ObjectEvent> list;
  v1::ListEventsRequest request;
  request.set_map(name.ToString());
  for (const v1::EventType type : query.types) request.add_types(type);
  for (const ObjectId object : query.objects) request.add_object_ids(object.value());
  for (const ClassId class_id : query.classes) request.add_class_ids(class_id.value());
  request.set_first_number(query.first.value());
  request.set_changed_since(query.changed_since.value());
  if (query.start) *request.mutable_start_time() = ToProto(*query.start);
  if (query.end) *request.mutable_end_time() = ToProto(*query.end);
  request.set_page_size(kEventsPerPage);
  do {
    auto page = Call(queries_.get(), &QueryStub::ListEvents, request, options_.call_timeout);
    if (!page.ok()) return page.status();
    list.revision = Revision(page->revision());
    for (v1::ObjectEvent& event : *page->mutable_events()) list.entries.push_back(std::move(event));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return list;
}

absl::StatusOr<MapSnapshot> MapClient::GetMapSection(const MapName& name,
                                                     const VolumeSelection& selection) {
  v1::GetMapSectionRequest request;
  request.set_map(name.ToString());
  Select(selection, &request);
  grpc::ClientContext context;
  SetTimeout(&context, options_.stream_timeout);
  const auto stream = queries_->GetMapSection(&context, request);
  absl::StatusOr<MapSnapshot> section = ReadMapSection(stream.get());
  if (!section.ok()) context.TryCancel();
  const grpc::Status status = stream->Finish();
  if (section.ok() && !status.ok()) return FromGrpcStatus(status);
  return section;
}

absl::StatusOr<ExportSummary> MapClient::ExportMap(const MapName& name,
                                                   v1::ExportFormat format,
                                                   const VolumeSelection& selection,
                                                   const ChunkSink& sink) {
  v1::ExportMapRequest request;
  request.set_map(name.ToString());
  request.set_format(format);
  Select(selection, &request);
  grpc::ClientContext context;
  SetTimeout(&context, options_.stream_timeout);
  const auto stream = queries_->ExportMap(&context, request);
  ExportReader reader(sink);
  absl::Status taken;
  for (v1::ExportMapResponse message; taken.ok() && stream->Read(&message);) {
    taken = reader.Take(message);
  }
  if (!taken.ok()) context.TryCancel();
  const grpc::Status status = stream->Finish();
  if (!taken.ok()) return taken;
  if (!status.ok()) return FromGrpcStatus(status);
  return reader.Finish();
}

absl::StatusOr<std::vector<v1::FramePose>> MapClient::ListFramePoses(const MapName& name) {
  std::vector<v1::FramePose> poses;
  v1::ListFramePosesRequest request;
  request.set_map(name.ToString());
  request.set_page_size(kPosesPerPage);
  do {
    auto page = Call(queries_.get(), &QueryStub::ListFramePoses, request, options_.call_timeout);
    if (!page.ok()) return page.status();
    for (v1::FramePose& pose : *page->mutable_poses()) poses.push_back(std::move(pose));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return poses;
}

absl::StatusOr<MapList<v1::Robot>> MapClient::ListRobots(const MapName& name) {
  v1::ListRobotsRequest request;
  request.set_map(name.ToString());
  auto answer = Call(queries_.get(), &QueryStub::ListRobots, request, options_.call_timeout);
  if (!answer.ok()) return answer.status();
  return MapList<v1::Robot>{Revision(answer->revision()),
                            {std::make_move_iterator(answer->mutable_robots()->begin()),
                             std::make_move_iterator(answer->mutable_robots()->end())}};
}

}  // namespace steadymap
