#include "server/server.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <spdlog/spdlog.h>

#include "core/types/error.h"
#include "server/config/listen_address.h"
#include "server/config/live_limits.h"
#include "server/maintenance.h"
#include "server/mapping/map_directory.h"
#include "server/maps/map_service.h"
#include "server/process/frame_budget.h"
#include "server/process/memory_guard.h"
#include "server/process/worker_pool.h"
#include "server/query/query_service.h"
#include "server/rpc/active_calls.h"
#include "server/rpc/connection_acceptor.h"
#include "server/rpc/peer_limiter.h"
#include "server/rpc/request_reader.h"
#include "server/rpc/stream_limiter.h"
#include "server/upload/ingest_service.h"
#include "server/upload/upload_registry.h"
#include "server/watch/watch_hub.h"
#include "server/watch/watch_service.h"

namespace steadymap {
namespace {

// Each upload stream has at most one batch here, each call at most one task.
constexpr std::size_t kMaxWaitingBatches = 4096;
constexpr std::size_t kMaxWaitingCalls = 256;

// Memory that gRPC may use for incoming and outgoing messages, in addition to the queue bytes.
constexpr std::size_t kTransportBytes = std::size_t{256} << 20;

// gRPC's message limit, as a multiple of `max_message_bytes`. It is higher so that a client with a
// message between the limits receives the server's own error reason.
constexpr std::size_t kHardMessageLimitFactor = 2;

// During shutdown, calls of clients that read nothing for this long are cancelled.
constexpr absl::Duration kSlowClientGrace = absl::Seconds(2);

// Time for the client of a stalled watch to read again and receive the reason for its end. The
// watch keeps one message in memory until then.
constexpr absl::Duration kStallGrace = absl::Minutes(1);

// Applies to connections without calls. gRPC would wait up to 20 s for each client to answer a last
// ping. A frozen client never answers, and a Python client without calls polls every 5 s.
constexpr absl::Duration kDisconnectTime = absl::Milliseconds(200);

// Clients ping every 30 s. The server's pings detect vanished clients.
constexpr int kMinClientPingIntervalMs = 10'000;
constexpr int kServerPingIntervalMs = 60'000;
constexpr int kServerPingTimeoutMs = 20'000;

// A connection without a complete HTTP/2 handshake is closed after this time.
constexpr int kHandshakeTimeoutMs = 20'000;

constexpr char kIngestServiceName[] = "steadymap.v1.IngestService";
constexpr char kMapServiceName[] = "steadymap.v1.MapService";
constexpr char kQueryServiceName[] = "steadymap.v1.QueryService";
constexpr char kWatchServiceName[] = "steadymap.v1.WatchService";

// Threads for computation: one per core, and at least two, so that one long task does not block all
// others.
std::size_t ComputingThreads() { return std::max(2U, std::thread::hardware_concurrency()); }

// Threads that wait for the disk. One sync covers the writes of many maps.
constexpr std::size_t kLogThreads = 4;
constexpr std::size_t kAdminThreads = 4;

absl::Status CannotListen(const std::string& listen, absl::string_view reason) {
  return absl::UnavailableError(absl::StrCat("cannot listen on ", listen, ": ", reason));
}

}  // namespace

/// All parts of a running server. Members are declared in the order of construction, so that each
/// part outlives its users.
class Server::Parts {
 public:
  Parts(const ServerConfig& config, std::unique_ptr<Store> store);

  ~Parts() { Shutdown(std::chrono::milliseconds(0)); }

  absl::Status Start();
  void Drain();
  void Shutdown(std::chrono::milliseconds deadline);

  Heartbeat::Clock::time_point last_progress() const;
  void SetLimits(const LimitOptions& limits);

  int port() const { return acceptor_->port(); }

  grpc::Server& grpc_server() { return *grpc_server_; }

 private:
  absl::Status Listen();
  void Configure(grpc::ServerBuilder* builder);
  void UpdateHealth();
  std::vector<const WorkerPool*> pools() const;

  const ServerConfig config_;
  const std::unique_ptr<Store> store_;
  LiveLimits limits_;
  ActiveCalls calls_;
  MemoryGuard memory_;
  FrameBudget budget_;
  FrameBudget read_budget_;
  UploadRegistry registry_;
  WatchHub watch_hub_;
  WorkerPool log_pool_;
  WorkerPool map_pool_;
  StreamLimiter streams_;
  MapDirectory maps_;
  WorkerPool decoders_;
  WorkerPool admin_pool_;
  WorkerPool readers_;
  WorkerPool watchers_;
  IngestService ingest_service_;
  MapService map_service_;
  QueryService query_service_;
  PeerLimiter watch_openings_;
  WatchService watch_service_;
  std::optional<Maintenance> maintenance_;
  std::unique_ptr<ConnectionAcceptor> acceptor_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections_;
  std::unique_ptr<grpc::Server> grpc_server_;
  std::atomic<grpc::HealthCheckServiceInterface*> health_service_ = nullptr;
  std::atomic<bool> draining_ = false;
  std::atomic<bool> shut_down_ = false;
};

Server::Parts::Parts(const ServerConfig& config, std::unique_ptr<Store> store)
    : config_(config),
      store_(std::move(store)),
      limits_(config.limits),
      memory_(config.limits.memory_bytes),
      budget_(config.limits.queue_bytes_total),
      read_budget_(config.limits.queue_bytes_total / 2),
      registry_(MaxUploadStreams(config.limits)),
      watch_hub_({.store = store_.get(),
                  .max_watches = config.watch.max_watches,
                  .stall_timeout = absl::FromChrono(config.watch.stall_timeout),
                  .stall_grace = kStallGrace}),
      log_pool_("log", kLogThreads, kMaxWaitingCalls),
      map_pool_("map", ComputingThreads(), kMaxWaitingCalls),
      streams_({.stall_timeout = config.watch.stall_timeout}),
      maps_({store_.get(),
             &budget_,
             &read_budget_,
             &log_pool_,
             &map_pool_,
             &memory_,
             config.commit,
             config.limits.queue_bytes_per_map,
             [this](MapKey map) { watch_hub_.OnCommit(map); }}),
      decoders_("decode", ComputingThreads(), kMaxWaitingBatches),
      admin_pool_("admin", kAdminThreads, kMaxWaitingCalls),
      readers_("read", ComputingThreads(), kMaxWaitingCalls),
      watchers_("watch", 2, config.watch.max_watches + kMaxWaitingCalls),
      ingest_service_({&maps_,
                       &registry_,
                       &decoders_,
                       &limits_,
                       read_budget_.OpenAccount(config.limits.queue_bytes_total / 4)}),
      map_service_({&maps_, &registry_, &watch_hub_, &admin_pool_, config.retention}),
      query_service_({&maps_, store_.get(), &readers_, &streams_}),
      watch_openings_({.per_second = static_cast<double>(config.watch.openings_per_second),
                       .burst = 2.0 * static_cast<double>(config.watch.max_watches)}),
      watch_service_({&maps_, &watch_hub_, &watchers_, &watch_openings_}) {}

absl::Status Server::Parts::Start() {
  if (absl::Status status = maps_.Load(); !status.ok()) return status;
  maintenance_.emplace(
      Maintenance::Dependencies{&maps_, &registry_, &watch_hub_, &streams_, store_.get()},
      config_.retention,
      config_.sessions);
  if (absl::Status status = Listen(); !status.ok()) return status;
  health_service_ = grpc_server_->GetHealthCheckService();
  UpdateHealth();
  spdlog::info("serving {} maps on {}, port {}", maps_.All().size(), config_.listen, port());
  return absl::OkStatus();
}

absl::Status Server::Parts::Listen() {
  const std::optional<ListenAddress> address = ParseListenAddress(config_.listen);
  if (!address) return absl::InvalidArgumentError("invalid address " + config_.listen);
  absl::StatusOr<std::unique_ptr<ConnectionAcceptor>> acceptor =
      ConnectionAcceptor::Listen(*address, config_.limits.max_connections);
  if (!acceptor.ok()) return CannotListen(config_.listen, acceptor.status().message());
  acceptor_ = *std::move(acceptor);
  grpc::EnableDefaultHealthCheckService(true);
  // Both calls register a plugin with all gRPC server builders that the process creates later.
  if (config_.reflection) grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  if (config_.channelz) grpc::channelz::experimental::InitChannelzService();
  grpc::ServerBuilder builder;
  Configure(&builder);
  connections_ = builder.experimental().AddExternalConnectionAcceptor(
      grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
      grpc::InsecureServerCredentials());
  builder.RegisterService(&ingest_service_);
  builder.RegisterService(&map_service_);
  builder.RegisterService(&query_service_);
  builder.RegisterService(&watch_service_);
  grpc_server_ = builder.BuildAndStart();
  if (grpc_server_ == nullptr) return CannotListen(config_.listen, "the gRPC server did not start");
  acceptor_->Start([this](int connection, int listener) {
    grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
    parameters.fd = connection;
    parameters.listener_fd = listener;
    connections_->HandleNewConnection(&parameters);
  });
  return absl::OkStatus();
}

void Server::Parts::Configure(grpc::ServerBuilder* builder) {
  const std::size_t largest_request =
      std::max(config_.limits.max_message_bytes, kPointRequestLimits.max_bytes);
  builder->SetMaxReceiveMessageSize(static_cast<int>(kHardMessageLimitFactor * largest_request));
  // gRPC 1.51 decompresses a message before it checks the size limit, so compression is disabled as
  // a protection against decompression bombs.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  grpc::ResourceQuota quota("steadymapd");
  quota.Resize(kTransportBytes);
  builder->SetResourceQuota(quota);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(calls_.MakeInterceptorFactory());
  builder->experimental().SetInterceptorCreators(std::move(interceptors));
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              kMinClientPingIntervalMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kServerPingIntervalMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kServerPingTimeoutMs);
  builder->AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeTimeoutMs);
}

void Server::Parts::UpdateHealth() {
  grpc::HealthCheckServiceInterface* health = health_service_;
  if (health == nullptr) return;
  // A failure of one map does not change the health of the server. The condition of the map reports
  // it.
  const bool serves = !draining_;
  health->SetServingStatus("", serves);
  for (const char* service :
       {kIngestServiceName, kMapServiceName, kQueryServiceName, kWatchServiceName}) {
    health->SetServingStatus(service, serves);
  }
}

void Server::Parts::Drain() {
  if (draining_.exchange(true)) return;
  // A server that failed to listen has no streams to drain; only its error is logged.
  if (grpc_server_ != nullptr) {
    spdlog::info("draining: {} upload streams are open", registry_.stream_count());
  }
  UpdateHealth();
  registry_.Drain();
}

// Order of shutdown: refuse new uploads, finish the accepted ones, deliver the commits to watchers,
// end calls, close connections, then stop the threads in pipeline order, so that no thread submits
// work to a stopped one.
void Server::Parts::Shutdown(std::chrono::milliseconds deadline) {
  if (shut_down_.exchange(true)) return;
  const absl::Time end = absl::Now() + absl::FromChrono(deadline);
  Drain();
  if (!registry_.AwaitEmpty(end))
    spdlog::warn("some uploads had not ended at the shutdown deadline");
  watch_hub_.Drain();
  if (!watch_hub_.AwaitEmpty(std::min(end, absl::Now() + kSlowClientGrace))) watch_hub_.CancelAll();
  if (!calls_.AwaitEnd(end, kSlowClientGrace))
    spdlog::warn("some calls were cancelled by the shutdown");
  // Frames that wait for free disk space are in the log and are integrated at the next start.
  store_->StopWaitingForDisk();
  health_service_ = nullptr;
  if (acceptor_ != nullptr) acceptor_->Stop();
  if (grpc_server_ != nullptr) {
    grpc_server_->Shutdown(absl::ToChronoTime(std::min(end, absl::Now() + kDisconnectTime)));
  }
  maintenance_.reset();
  decoders_.Stop();
  admin_pool_.Stop();
  readers_.Stop();
  watchers_.Stop();
  maps_.Close(DrainingError());
  log_pool_.Stop();
  map_pool_.Stop();
}

std::vector<const WorkerPool*> Server::Parts::pools() const {
  return {&log_pool_, &map_pool_, &decoders_, &admin_pool_, &readers_, &watchers_};
}

Heartbeat::Clock::time_point Server::Parts::last_progress() const {
  // Waiting for free disk space is no fault, and a restart by the watchdog would not end it.
  if (store_->IsWaitingForDisk()) return Heartbeat::Clock::now();
  Heartbeat::Clock::time_point oldest = maintenance_->heartbeat().last();
  for (const WorkerPool* pool : pools()) {
    if (const auto start = pool->oldest_start()) oldest = std::min(oldest, *start);
  }
  return oldest;
}

void Server::Parts::SetLimits(const LimitOptions& limits) {
  LimitOptions live = limits;
  live.max_message_bytes = config_.limits.max_message_bytes;
  limits_.Set(live);
  acceptor_->SetMaxConnections(limits.max_connections);
  registry_.SetMaxStreams(MaxUploadStreams(limits));
  memory_.SetMax(limits.memory_bytes);
  budget_.SetTotal(limits.queue_bytes_total);
  read_budget_.SetTotal(limits.queue_bytes_total / 2);
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerConfig& config,
                                                      std::unique_ptr<Store> store) {
  auto parts = std::make_unique<Parts>(config, std::move(store));
  if (absl::Status status = parts->Start(); !status.ok()) return status;
  return std::unique_ptr<Server>(new Server(std::move(parts)));
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() = default;

int Server::port() const { return parts_->port(); }

std::shared_ptr<grpc::Channel> Server::InProcessChannel(const grpc::ChannelArguments& arguments) {
  return parts_->grpc_server().InProcessChannel(arguments);
}

void Server::Drain() { parts_->Drain(); }

void Server::Shutdown(std::chrono::milliseconds deadline) { parts_->Shutdown(deadline); }

std::chrono::steady_clock::time_point Server::last_progress() const {
  return parts_->last_progress();
}

void Server::SetLimits(const LimitOptions& limits) { parts_->SetLimits(limits); }

}  // namespace steadymap
