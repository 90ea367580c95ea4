#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include "client/transport/channel.h"
#include "core/types/crc32c.h"
#include "core/types/error.h"
#include "core/types/identifiers.h"
#include "proto/grpc_status.h"

#include "steadymap/v1/map_service.grpc.pb.h"
#include "steadymap/v1/query_service.grpc.pb.h"

namespace steadymap {

inline const MapName kKitchen{"default", "kitchen"};

inline grpc::Status NoSuchMap(const std::string& name) {
  return ToGrpcStatus(
      MakeError(absl::StatusCode::kNotFound, reason::kNotFound, "there is no map " + name, "name"));
}

/// Keeps maps in memory; pages have two maps.
class FakeMapService final : public v1::MapService::Service {
 public:
  std::map<std::string, v1::Map> maps;  ///< By name.

  grpc::Status CreateMap(grpc::ServerContext*,
                         const v1::CreateMapRequest* request,
                         v1::Map* answer) override {
    const std::string name = request->parent() + "/maps/" + request->map_id();
    if (maps.contains(name)) {
      return ToGrpcStatus(MakeError(
          absl::StatusCode::kAlreadyExists, reason::kAlreadyExists, name + " exists", "map_id"));
    }
    *answer = request->map();
    answer->set_name(name);
    maps[name] = *answer;
    return grpc::Status::OK;
  }

  grpc::Status GetMap(grpc::ServerContext*,
                      const v1::GetMapRequest* request,
                      v1::Map* answer) override {
    if (!maps.contains(request->name())) return NoSuchMap(request->name());
    *answer = maps[request->name()];
    return grpc::Status::OK;
  }

  grpc::Status ListMaps(grpc::ServerContext*,
                        const v1::ListMapsRequest* request,
                        v1::ListMapsResponse* answer) override {
    for (auto at = maps.upper_bound(request->page_token()); at != maps.end(); ++at) {
      if (answer->maps_size() == 2) {
        answer->set_next_page_token(answer->maps(1).name());
        break;
      }
      if (at->first.starts_with(request->parent() + "/")) *answer->add_maps() = at->second;
    }
    return grpc::Status::OK;
  }

  grpc::Status DeleteMap(grpc::ServerContext*,
                         const v1::DeleteMapRequest* request,
                         google::protobuf::Empty*) override {
    return maps.erase(request->name()) == 1 ? grpc::Status::OK : NoSuchMap(request->name());
  }
};

/// Returns prepared responses and records the requests.
class FakeQueryService final : public v1::QueryService::Service {
 public:
  v1::SampleDistanceResponse samples;
  std::vector<v1::GetMapSectionResponse> section;
  std::vector<v1::ExportMapResponse> file;
  grpc::Status export_status;
  std::vector<v1::FramePose> poses;
  std::vector<v1::Object> objects;
  std::vector<v1::ObjectEvent> events;
  std::vector<v1::Robot> robots;
  v1::CastRaysResponse hits;

  v1::SampleDistanceRequest sample_request;
  v1::GetMapSectionRequest section_request;
  v1::ExportMapRequest export_request;
  v1::ListObjectsRequest objects_request;
  v1::ListEventsRequest events_request;
  v1::CastRaysRequest rays_request;

  grpc::Status SampleDistance(grpc::ServerContext*,
                              const v1::SampleDistanceRequest* request,
                              v1::SampleDistanceResponse* answer) override {
    sample_request = *request;
    *answer = samples;
    return grpc::Status::OK;
  }

  grpc::Status CastRays(grpc::ServerContext*,
                        const v1::CastRaysRequest* request,
                        v1::CastRaysResponse* answer) override {
    rays_request = *request;
    *answer = hits;
    return grpc::Status::OK;
  }

  grpc::Status GetObject(grpc::ServerContext*,
                         const v1::GetObjectRequest* request,
                         v1::GetObjectResponse* answer) override {
    for (const v1::Object& object : objects) {
      if (object.id() == request->object_id()) *answer->mutable_object() = object;
    }
    return grpc::Status::OK;
  }

  grpc::Status ListObjects(grpc::ServerContext*,
                           const v1::ListObjectsRequest* request,
                           v1::ListObjectsResponse* answer) override {
    objects_request = *request;
    answer->set_revision(12);
    AnswerPage(objects, request->page_token(), answer->mutable_objects(), answer);
    return grpc::Status::OK;
  }

  grpc::Status ListEvents(grpc::ServerContext*,
                          const v1::ListEventsRequest* request,
                          v1::ListEventsResponse* answer) override {
    events_request = *request;
    answer->set_revision(12);
    AnswerPage(events, request->page_token(), answer->mutable_events(), answer);
    return grpc::Status::OK;
  }

  grpc::Status GetMapSection(grpc::ServerContext*,
                             const v1::GetMapSectionRequest* request,
                             grpc::ServerWriter<v1::GetMapSectionResponse>* stream) override {
    section_request = *request;
    // Copied: a client that cancels does not wait for the end of this call before the test
    // continues.
    const std::vector<v1::GetMapSectionResponse> messages = section;
    for (const v1::GetMapSectionResponse& message : messages) stream->Write(message);
    return grpc::Status::OK;
  }

  grpc::Status ExportMap(grpc::ServerContext*,
                         const v1::ExportMapRequest* request,
                         grpc::ServerWriter<v1::ExportMapResponse>* stream) override {
    export_request = *request;
    // Copied: a client that cancels does not wait for the end of this call before the test
    // continues.
    const std::vector<v1::ExportMapResponse> messages = file;
    grpc::Status status = export_status;
    for (const v1::ExportMapResponse& response : messages) stream->Write(response);
    return status;
  }

  grpc::Status ListFramePoses(grpc::ServerContext*,
                              const v1::ListFramePosesRequest* request,
                              v1::ListFramePosesResponse* answer) override {
    AnswerPage(poses, request->page_token(), answer->mutable_poses(), answer);
    return grpc::Status::OK;
  }

  grpc::Status ListRobots(grpc::ServerContext*,
                          const v1::ListRobotsRequest* request,
                          v1::ListRobotsResponse* answer) override {
    if (request->map() != kKitchen.ToString()) return NoSuchMap(request->map());
    answer->set_revision(12);
    for (const v1::Robot& robot : robots) *answer->add_robots() = robot;
    return grpc::Status::OK;
  }

  /// Makes `ExportMap` send these chunks between a header and a trailer with the length and
  /// checksum of `content`.
  void SetFile(const std::vector<std::string>& chunks, const std::string& content) {
    file.assign(1, {});
    file[0].mutable_header()->set_revision(7);
    file[0].mutable_header()->set_triangles(12);
    for (const std::string& chunk : chunks) file.emplace_back().set_chunk(chunk);
    v1::ExportMapResponse::Trailer& trailer = *file.emplace_back().mutable_trailer();
    trailer.set_file_bytes(content.size());
    trailer.set_crc32c(ExtendCrc32c(0, content));
  }

 private:
  /// Returns pages of two, whatever page size is requested.
  template <typename Message, typename Field, typename Answer>
  static void AnswerPage(const std::vector<Message>& list,
                         const std::string& token,
                         Field* field,
                         Answer* answer) {
    const std::size_t first = token.empty() ? 0 : std::stoul(token);
    for (std::size_t i = first; i < list.size() && i < first + 2; ++i) *field->Add() = list[i];
    if (first + 2 < list.size()) answer->set_next_page_token(std::to_string(first + 2));
  }
};

/// An in-process server with some services.
class FakeServer {
 public:
  template <typename... Services>
  explicit FakeServer(Services*... services) {
    grpc::ServerBuilder builder;
    (builder.RegisterService(services), ...);
    builder.SetMaxReceiveMessageSize(-1);
    server_ = builder.BuildAndStart();
  }

  ~FakeServer() { server_->Shutdown(std::chrono::system_clock::now()); }

  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  std::shared_ptr<grpc::Channel> channel() const { return server_->InProcessChannel({}); }

  /// For clients that open a channel for each attempt; they must not outlive the server.
  ChannelOpener channels() const {
    return [this] { return channel(); };
  }

 private:
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace steadymap
