#include "tests/watch/fleet_server.h"

#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

#include "proto/grpc_status.h"

#include "steadymap/v1/ingest_service.grpc.pb.h"
#include "steadymap/v1/map_service.grpc.pb.h"

namespace steadymap {
namespace {

constexpr std::chrono::seconds kHangTime{60};

void SetHangDeadline(grpc::ClientContext* context) {
  context->set_deadline(std::chrono::system_clock::now() + kHangTime);
  context->set_wait_for_ready(true);
}

void Require(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

}  // namespace

FleetServer::FleetServer() {
  Start();
  v1::CreateMapRequest request;
  request.set_parent("tenants/test");
  request.set_map_id("hall");
  request.mutable_map()->mutable_config()->set_policy(v1::UPDATE_POLICY_POCD);
  grpc::ClientContext context;
  SetHangDeadline(&context);
  v1::Map map;
  Require(FromGrpcStatus(v1::MapService::NewStub(Connect())->CreateMap(&context, request, &map)));
}

FleetServer::~FleetServer() { server_->Shutdown(std::chrono::milliseconds(0)); }

void FleetServer::Start() {
  StoreOptions options;
  options.kept_change_lists = 4;
  absl::StatusOr<std::unique_ptr<Store>> store = Store::Open(folder_.path() / "data", options);
  Require(store.status());
  auto recording = std::make_unique<RecordingStore>(*std::move(store), &history_, &killed_);
  store_ = recording.get();
  ServerConfig config;
  config.listen = "127.0.0.1:0";
  config.commit.max_delay = std::chrono::milliseconds(10);
  config.commit.max_frames = 4;
  // These watchers reconnect all the time without delay.
  config.watch.openings_per_second = 1'000'000;
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(config, std::move(recording));
  Require(server.status());
  server_ = *std::move(server);
  const absl::MutexLock lock(&mutex_);
  port_ = server_->port();
}

void FleetServer::Kill() {
  killed_ = true;
  server_->Shutdown(std::chrono::milliseconds(0));
  server_.reset();
  killed_ = false;
  Start();
}

void FleetServer::Compact() {
  GetMap();  // Waits until it is open.
  const absl::StatusOr<std::vector<MapRecord>> maps = store_->ListMaps();
  Require(maps.status());
  // At this uptime all lists are new: only their number counts.
  Require(store_->Trim(maps->front(), {.uptime = MapUptime(0)}));
}

std::string FleetServer::address() const {
  const absl::MutexLock lock(&mutex_);
  return "127.0.0.1:" + std::to_string(port_);
}

std::shared_ptr<grpc::Channel> FleetServer::Connect() const {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  // Prevents the reuse of connections to killed servers.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address(), grpc::InsecureChannelCredentials(), arguments);
}

void FleetServer::Upload(const std::string& robot, const std::vector<v1::Frame>& frames) {
  const std::uint64_t first = uploaded_ + 1;
  uploaded_ += frames.size();
  Require(UploadOnce(robot, frames, first));
}

absl::Status FleetServer::UploadOnce(const std::string& robot,
                                     const std::vector<v1::Frame>& frames,
                                     std::uint64_t first_client_seq) {
  v1::UploadFrameBatchRequest request;
  request.set_map(map_);
  request.set_robot(robot);
  // One session per call: gaps in a robot's sequence are irrelevant here.
  request.set_session("s" + std::to_string(first_client_seq));
  request.set_wait_for(v1::ACK_LEVEL_DURABLE);
  request.mutable_batch()->set_first_client_seq(1);
  for (const v1::Frame& frame : frames) *request.mutable_batch()->add_frames() = frame;
  v1::UploadFrameBatchResponse response;
  grpc::ClientContext context;
  SetHangDeadline(&context);
  return FromGrpcStatus(
      v1::IngestService::NewStub(Connect())->UploadFrameBatch(&context, request, &response));
}

v1::Map FleetServer::GetMap() const {
  v1::GetMapRequest request;
  request.set_name(map_);
  grpc::ClientContext context;
  SetHangDeadline(&context);
  v1::Map map;
  Require(FromGrpcStatus(v1::MapService::NewStub(Connect())->GetMap(&context, request, &map)));
  return map;
}

void FleetServer::AwaitIntegrated() {
  const auto deadline = std::chrono::steady_clock::now() + kHangTime;
  while (std::chrono::steady_clock::now() < deadline) {
    const v1::MapState state = GetMap().state();
    if (state.revision() == state.durable_map_seq()) return;
    std::this_thread::yield();
  }
  throw std::runtime_error("the frames were not integrated");
}

}  // namespace steadymap
