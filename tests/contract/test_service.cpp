#include "tests/contract/test_service.h"

#include <chrono>
#include <stdexcept>

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>

namespace steadymap {
namespace {

constexpr std::chrono::seconds kHang{60};

}  // namespace

std::string TransportName(const ::testing::TestParamInfo<Transport>& info) {
  return info.param == Transport::kInProcess ? "InProcess" : "Loopback";
}

TestService::TestService(Transport transport, const std::function<void(ServerConfig*)>& adjust)
    : TestService(transport, nullptr, adjust) {}

TestService::TestService(Transport transport,
                         std::unique_ptr<Store> store,
                         const std::function<void(ServerConfig*)>& adjust)
    : transport_(transport) {
  config_.listen = "127.0.0.1:0";
  // Automatic commits would make tests depend on time.
  config_.commit.max_delay = std::chrono::hours(1);
  if (adjust) adjust(&config_);
  if (store == nullptr) {
    memory_store_ = std::make_unique<MemoryStore>();
    store = memory_store_->Share();
  }
  Start(std::move(store));
}

TestService::~TestService() { server_->Shutdown(std::chrono::milliseconds(0)); }

void TestService::Restart() {
  server_->Shutdown(std::chrono::milliseconds(0));
  server_.reset();
  Start(memory_store_->Share());
}

void TestService::Start(std::unique_ptr<Store> store) {
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(config_, std::move(store));
  if (!server.ok()) throw std::runtime_error(server.status().ToString());
  server_ = *std::move(server);
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  // Prevents the reuse of a connection to an earlier server of this process at the same port.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  channel_ = transport_ == Transport::kInProcess
                 ? server_->InProcessChannel(arguments)
                 : grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(server_->port()),
                                             grpc::InsecureChannelCredentials(),
                                             arguments);
  maps_ = v1::MapService::NewStub(channel_);
  ingest_ = v1::IngestService::NewStub(channel_);
  queries_ = v1::QueryService::NewStub(channel_);
}

std::string TestService::CreateMap(const std::string& id, std::uint64_t byte_budget) {
  v1::Map map;
  map.set_byte_budget(byte_budget);
  return CreateMap(id, map);
}

std::string TestService::CreatePocdMap(const std::string& id) {
  v1::Map map;
  map.mutable_config()->set_policy(v1::UPDATE_POLICY_POCD);
  return CreateMap(id, map);
}

std::string TestService::CreateMap(const std::string& id, const v1::Map& map) {
  v1::CreateMapRequest request;
  request.set_parent("tenants/test");
  request.set_map_id(id);
  *request.mutable_map() = map;
  v1::Map created;
  const absl::Status status =
      Call([&](auto* context) { return maps().CreateMap(context, request, &created); });
  if (!status.ok()) throw std::runtime_error(status.ToString());
  return created.name();
}

absl::StatusOr<v1::Map> TestService::GetMap(const std::string& name) {
  v1::GetMapRequest request;
  request.set_name(name);
  v1::Map map;
  absl::Status status = Call([&](auto* context) { return maps().GetMap(context, request, &map); });
  if (!status.ok()) return status;
  return map;
}

absl::Status TestService::DeleteMap(const std::string& name) {
  v1::DeleteMapRequest request;
  request.set_name(name);
  google::protobuf::Empty response;
  return Call([&](auto* context) { return maps().DeleteMap(context, request, &response); });
}

absl::StatusOr<std::string> TestService::Export(const std::string& name, v1::ExportFormat format) {
  v1::ExportMapRequest request;
  request.set_map(name);
  request.set_format(format);
  return Export(request);
}

absl::StatusOr<std::string> TestService::Export(const v1::ExportMapRequest& request) {
  grpc::ClientContext context;
  SetDeadline(&context);
  const auto reader = queries().ExportMap(&context, request);
  v1::ExportMapResponse response;
  std::string file;
  while (reader->Read(&response)) file += response.chunk();
  if (absl::Status status = FromGrpcStatus(reader->Finish()); !status.ok()) return status;
  return file;
}

void SetDeadline(grpc::ClientContext* context) {
  context->set_deadline(std::chrono::system_clock::now() + kHang);
}

}  // namespace steadymap
