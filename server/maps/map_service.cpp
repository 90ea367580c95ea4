#include "server/maps/map_service.h"

#include <algorithm>
#include <future>
#include <utility>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "server/maps/map_resource.h"
#include "server/process/descriptors.h"
#include "server/rpc/message_call.h"
#include "server/rpc/page_token.h"
#include "server/rpc/pool_call.h"

namespace steadymap {
namespace {

constexpr std::uint32_t kDefaultPageSize = 100;
constexpr std::uint32_t kMaxPageSize = 1000;

constexpr std::size_t kMaxMaps = 10'000;

constexpr std::size_t kRememberedDeletions = 1000;

/// Returns OK if the process has enough descriptors for one more map. A map without a free
/// descriptor for a file could no longer be written.
absl::Status CheckRoom(std::size_t map_count) {
  if (map_count >= kMaxMaps) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     reason::kQueueFull,
                     absl::StrCat("the server has ", map_count, " maps, which is the maximum"));
  }
  if (CountFreeDescriptors() >= kDescriptorsPerMap) return absl::OkStatus();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   reason::kQueueFull,
                   absl::StrCat("the server may have ",
                                DescriptorLimit(),
                                " files and connections open, and ",
                                map_count,
                                " maps and their clients use them up; raise this limit (ulimit -n) "
                                "to allow more maps"));
}

}  // namespace

grpc::ServerUnaryReactor* MapService::CreateMap(grpc::CallbackServerContext* /*context*/,
                                                const grpc::ByteBuffer* request,
                                                grpc::ByteBuffer* response) {
  return StartMessageCall<v1::CreateMapRequest, v1::Map>(
      *request, response, kPlainRequestLimits, [this](const auto& call) {
        return AnswerLaterOnPool(dependencies_.pool, [this, call](const FinishCall& finish) {
          Create(call.request(), call.response(), [call, finish](const absl::Status& status) {
            finish(call.Answer(status));
          });
        });
      });
}

grpc::ServerUnaryReactor* MapService::GetMap(grpc::CallbackServerContext* /*context*/,
                                             const grpc::ByteBuffer* request,
                                             grpc::ByteBuffer* response) {
  return StartMessageCall<v1::GetMapRequest, v1::Map>(
      *request, response, kPlainRequestLimits, [this](const auto& call) {
        const auto map = dependencies_.maps->Find(call.request().name(), "name");
        return AnswerOnPoolAfter(
            [&map](std::function<void()> resume) {
              if (map.ok()) return (*map)->WhenOpened(std::move(resume));
              resume();
            },
            dependencies_.pool,
            [map, call](const Cancellation&) {
              if (!map.ok()) return map.status();
              *call.response() = MakeMapResource(**map);
              return call.Answer(ApplyReadMask(call.request().read_mask(), call.response()));
            });
      });
}

grpc::ServerUnaryReactor* MapService::ListMaps(grpc::CallbackServerContext* /*context*/,
                                               const grpc::ByteBuffer* request,
                                               grpc::ByteBuffer* response) {
  return StartMessageCall<v1::ListMapsRequest, v1::ListMapsResponse>(
      *request, response, kPlainRequestLimits, [this](const auto& call) {
        return AnswerOnPool(dependencies_.pool, [this, call](const Cancellation&) {
          return call.Answer(List(call.request(), call.response()));
        });
      });
}

grpc::ServerUnaryReactor* MapService::UpdateMap(grpc::CallbackServerContext* /*context*/,
                                                const grpc::ByteBuffer* request,
                                                grpc::ByteBuffer* response) {
  return StartMessageCall<v1::UpdateMapRequest, v1::Map>(
      *request, response, kPlainRequestLimits, [this](const auto& call) {
        return AnswerOnPool(dependencies_.pool, [this, call](const Cancellation&) {
          return call.Answer(Update(call.request(), call.response()));
        });
      });
}

grpc::ServerUnaryReactor* MapService::DeleteMap(grpc::CallbackServerContext* /*context*/,
                                                const grpc::ByteBuffer* request,
                                                grpc::ByteBuffer* response) {
  return StartMessageCall<v1::DeleteMapRequest, google::protobuf::Empty>(
      *request, response, kPlainRequestLimits, [this](const auto& call) {
        return AnswerOnPool(dependencies_.pool, [this, call](const Cancellation&) {
          return call.Answer(Delete(call.request()));
        });
      });
}

/// Creates the map, and finishes the call once the map is open.
void MapService::Create(const v1::CreateMapRequest& request,
                        v1::Map* response,
                        const FinishCall& finish) {
  const absl::StatusOr<MapRecord> record = ReadNewMap(request, dependencies_.retention);
  if (!record.ok()) return finish(record.status());
  absl::StatusOr<std::shared_ptr<MapRuntime>> map = absl::NotFoundError("");
  {
    const WriterMutex::Lock turn(&changes_);
    map = dependencies_.maps->Get(record->name, "map_id");
    if (map.ok()) {
      const MapRecord existing = (*map)->record();
      const bool same = !record->request_id.empty() && existing.condition.ok() &&
                        existing.request_id == record->request_id &&
                        existing.config == record->config;
      if (!same) {
        return finish(
            MakeError(absl::StatusCode::kAlreadyExists,
                      reason::kAlreadyExists,
                      absl::StrCat("the map ", record->name.ToString(), " already exists"),
                      "map_id"));
      }
    } else {
      if (absl::Status room = CheckRoom(dependencies_.maps->All().size()); !room.ok()) {
        return finish(room);
      }
      map = dependencies_.maps->Create(*record);
      if (!map.ok()) return finish(map.status());
      spdlog::info("map {}: created, voxel size {} m, truncation {} m",
                   record->name.ToString(),
                   record->config.voxel_size_m,
                   record->config.truncation_m);
    }
  }
  (*map)->WhenOpened([map = *map, response, finish] {
    *response = MakeMapResource(*map);
    finish(absl::OkStatus());
  });
}

absl::Status MapService::List(const v1::ListMapsRequest& request, v1::ListMapsResponse* response) {
  const std::string& parent = request.parent();
  const std::string tenant = TenantOf(parent);
  if (!IsValidId(tenant)) {
    return InvalidField(
        reason::kBadName,
        "parent",
        absl::StrCat("parent must be tenants/{tenant}, got \"", parent.substr(0, 100), "\""));
  }
  const absl::StatusOr<std::size_t> page_size =
      ReadPageSize(request.page_size(), kDefaultPageSize, kMaxPageSize);
  if (!page_size.ok()) return page_size.status();
  const std::string scope = "maps of " + tenant + " behind ";
  const absl::StatusOr<std::string> after = ReadPageToken(scope, request.page_token());
  if (!after.ok()) return after.status();
  // One more than requested, to find out whether another page follows.
  const std::vector<std::shared_ptr<MapRuntime>> maps =
      dependencies_.maps->List(tenant, *after, *page_size + 1);
  std::size_t bytes = 0;
  std::size_t shown = 0;
  while (shown < maps.size() && shown < *page_size && bytes < kMaxPageBytes) {
    v1::Map* map = response->add_maps();
    *map = MakeMapResource(*maps[shown++]);
    bytes += map->ByteSizeLong();
  }
  if (shown < maps.size()) {
    response->set_next_page_token(MakePageToken(scope, maps[shown - 1]->name().map));
  }
  return absl::OkStatus();
}

absl::Status MapService::Update(const v1::UpdateMapRequest& request, v1::Map* response) {
  const WriterMutex::Lock turn(&changes_);
  const absl::StatusOr<std::shared_ptr<MapRuntime>> map =
      dependencies_.maps->Find(request.map().name(), "map.name");
  if (!map.ok()) return map.status();
  MapRecord record = (*map)->record();
  if (!record.condition.ok()) return record.condition;
  const std::string& request_id = request.request_id();
  const bool is_repeated = !request_id.empty() && record.change_request_id == request_id;
  if (!is_repeated) {
    absl::Status status = CheckEtag(record, request.map().etag(), "map.etag");
    if (status.ok()) status = CheckRequestId(request_id);
    if (status.ok()) {
      status = ApplyUpdate(request.map(), request.update_mask(), dependencies_.retention, &record);
    }
    if (status.ok()) status = AddClasses(request, map->get());
    if (!status.ok()) return status;
    ++record.version;
    record.change_request_id = request_id;
    if (status = dependencies_.maps->Update(**map, record); !status.ok()) return status;
  }
  *response = MakeMapResource(**map);
  return absl::OkStatus();
}

/// Adds the classes of an update and waits until they are durable, so that the next change finds
/// them.
absl::Status MapService::AddClasses(const v1::UpdateMapRequest& request, MapRuntime* map) {
  if (absl::Status status = map->CheckReads(); !status.ok()) return status;
  absl::StatusOr<std::vector<SemanticClass>> added =
      ReadAddedClasses(request.map(), request.update_mask(), map->classes());
  if (!added.ok()) return added.status();
  if (added->empty()) return absl::OkStatus();
  const auto result = std::make_shared<std::promise<absl::Status>>();
  map->AddClasses(*std::move(added),
                  [result](const absl::Status& status) { result->set_value(status); });
  return WithFieldPrefix(result->get_future().get(), "map.config");
}

absl::Status MapService::Delete(const v1::DeleteMapRequest& request) {
  const absl::StatusOr<MapName> name = MapName::Parse(request.name());
  if (!name.ok()) return name.status();
  const WriterMutex::Lock turn(&changes_);
  const absl::StatusOr<std::shared_ptr<MapRuntime>> map = dependencies_.maps->Get(*name, "name");
  const Deletion deletion{*name, request.request_id()};
  const bool is_repeated =
      !deletion.request_id.empty() &&
      std::find(deletions_.begin(), deletions_.end(), deletion) != deletions_.end();
  if (is_repeated) return absl::OkStatus();
  if (!map.ok()) return map.status();
  absl::Status status = CheckEtag((*map)->record(), request.etag(), "etag");
  if (status.ok()) status = CheckRequestId(request.request_id());
  if (!status.ok()) return status;
  const MapKey key = (*map)->key();
  status = dependencies_.maps->Delete(*map, [this, key](const absl::Status& ended) {
    dependencies_.registry->EndMap(key, ended);
    dependencies_.watches->EndMap(key, ended);
  });
  if (status.ok() && !deletion.request_id.empty()) {
    deletions_.push_back(deletion);
    if (deletions_.size() > kRememberedDeletions) deletions_.pop_front();
  }
  return status;
}

}  // namespace steadymap
