#include "client/map_client.h"

#include <utility>

#include <absl/strings/str_cat.h>
#include <grpcpp/client_context.h>

#include "core/error.h"
#include "core/tsdf_codec.h"
#include "proto/convert_geometry.h"
#include "proto/grpc_status.h"

namespace steadymap {
namespace {

using MapStub = v1::MapService::StubInterface;
using QueryStub = v1::QueryService::StubInterface;

constexpr std::uint32_t kMapsPerPage = 1000;
constexpr std::uint32_t kPosesPerPage = 10'000;

// A call with one answer.
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

absl::Status ProtocolError(const char* what) {
  return MakeError(absl::StatusCode::kInternal, reason::kInternal, what);
}

absl::Status StoreLeaves(const v1::GetMapSectionResponse::Leaves& leaves, MapSnapshot* section) {
  LeafVoxels voxels;
  for (const v1::PackedLeaf& leaf : leaves.leaves()) {
    // Objects have grids of their own; a client of this release knows only the background.
    if (leaf.object_id() != kBackgroundId.value()) continue;
    const LeafOrigin origin{leaf.origin_x(), leaf.origin_y(), leaf.origin_z()};
    if (origin != LeafOf(origin.x, origin.y, origin.z)) {
      return ProtocolError("the server sent a leaf whose origin is not a multiple of 8");
    }
    absl::Status status = UnpackLeaf(leaf.packed(), section->scale, &voxels);
    if (!status.ok()) return status;
    section->background.MutableTile(origin).StoreLeaf(origin, voxels);
  }
  return absl::OkStatus();
}

// Reads a section stream to its end or to the first error.
absl::StatusOr<MapSnapshot> ReadSection(
    grpc::ClientReaderInterface<v1::GetMapSectionResponse>* stream) {
  MapSnapshot section;
  bool has_header = false;
  v1::GetMapSectionResponse response;
  while (stream->Read(&response)) {
    if (response.has_header()) {
      section = MapSnapshot({response.header().voxel_size_m(), response.header().truncation_m()});
      section.revision = Revision(response.header().revision());
      if (!(section.scale.voxel_size_m > 0.0 && section.scale.truncation_m > 0.0)) {
        return ProtocolError("the server sent a map section with voxels of no size");
      }
      has_header = true;
    } else if (!has_header) {
      return ProtocolError("the server sent a map section without a header");
    } else {
      const absl::Status status = StoreLeaves(response.leaves(), &section);
      if (!status.ok()) return status;
    }
  }
  return section;
}

// Reads an export stream to its end or to the first error.
absl::StatusOr<v1::ExportMapResponse::Header> ReadExport(
    grpc::ClientReaderInterface<v1::ExportMapResponse>* stream, const MapClient::ChunkSink& sink) {
  v1::ExportMapResponse::Header header;
  std::uint64_t received_bytes = 0;
  v1::ExportMapResponse response;
  while (stream->Read(&response)) {
    if (response.has_header()) {
      header = response.header();
      continue;
    }
    received_bytes += response.chunk().size();
    absl::Status status = sink(response.chunk());
    if (!status.ok()) return status;
  }
  // A stream that broke is too short as well; its own status says more, and goes first.
  if (received_bytes == header.file_bytes()) return header;
  return MakeError(absl::StatusCode::kDataLoss,
                   reason::kChecksum,
                   absl::StrCat("the server announced a file of ",
                                header.file_bytes(),
                                " bytes and sent ",
                                received_bytes));
}

}  // namespace

MapClient::MapClient(const std::shared_ptr<grpc::ChannelInterface>& channel,
                     const MapClientOptions& options)
    : options_(options),
      maps_(v1::MapService::NewStub(channel)),
      queries_(v1::QueryService::NewStub(channel)) {}

absl::StatusOr<v1::Map> MapClient::CreateMap(const MapName& name, const v1::MapConfig& config) {
  v1::CreateMapRequest request;
  request.set_parent("tenants/" + name.tenant);
  request.set_map_id(name.map);
  *request.mutable_map()->mutable_config() = config;
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
    return ProtocolError("the server answered with another number of samples than points");
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
    return ProtocolError("the server answered with another number of hits than rays");
  }
  return response;
}

absl::StatusOr<MapSnapshot> MapClient::GetMapSection(const MapName& name,
                                                     const std::optional<Box>& box) {
  v1::GetMapSectionRequest request;
  request.set_map(name.ToString());
  if (box) *request.mutable_box() = ToProto(*box);
  grpc::ClientContext context;
  SetTimeout(&context, options_.stream_timeout);
  const auto stream = queries_->GetMapSection(&context, request);
  absl::StatusOr<MapSnapshot> section = ReadSection(stream.get());
  if (!section.ok()) context.TryCancel();
  const grpc::Status status = stream->Finish();
  if (section.ok() && !status.ok()) return FromGrpcStatus(status);
  return section;
}

absl::StatusOr<v1::ExportMapResponse::Header> MapClient::ExportMap(const MapName& name,
                                                                   v1::ExportFormat format,
                                                                   const std::optional<Box>& box,
                                                                   const ChunkSink& sink) {
  v1::ExportMapRequest request;
  request.set_map(name.ToString());
  request.set_format(format);
  if (box) *request.mutable_box() = ToProto(*box);
  grpc::ClientContext context;
  SetTimeout(&context, options_.stream_timeout);
  const auto stream = queries_->ExportMap(&context, request);
  absl::Status sink_status;
  absl::StatusOr<v1::ExportMapResponse::Header> header =
      ReadExport(stream.get(), [&](std::string_view chunk) {
        sink_status = sink(chunk);
        if (!sink_status.ok()) context.TryCancel();
        return sink_status;
      });
  const grpc::Status status = stream->Finish();
  if (!sink_status.ok()) return sink_status;
  if (!status.ok()) return FromGrpcStatus(status);
  return header;
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

}  // namespace steadymap
