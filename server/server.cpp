#include "server/server.h"

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>
#include <spdlog/spdlog.h>

#include "core/error.h"
#include "server/frame_budget.h"
#include "server/housekeeper.h"
#include "server/ingest_service.h"
#include "server/live_limits.h"
#include "server/log_writer.h"
#include "server/map_directory.h"
#include "server/map_service.h"
#include "server/query_service.h"
#include "server/stream_gate.h"
#include "server/upload_roster.h"
#include "server/watch_hub.h"
#include "server/watch_service.h"
#include "server/worker_pool.h"

namespace steadymap {
namespace {

// A stream keeps at most one batch here, a call likewise.
constexpr std::size_t kMaxWaitingBatches = 4096;
constexpr std::size_t kMaxWaitingCalls = 256;

// What gRPC may hold for messages on their way in and out, beside the queues' bytes.
constexpr std::size_t kTransportBytes = std::size_t{256} << 20;

// gRPC's own limit lies above ours, so that a client hears our reason for a message that is too
// large, up to this factor.
constexpr std::size_t kHardMessageLimitFactor = 2;

// For watchers to take their last step and the goodbye; who does not read is cut off.
constexpr absl::Duration kGoodbyeTime = absl::Seconds(2);

// The client's pings are 30 s apart; ours find out about clients that have vanished.
constexpr int kMinClientPingIntervalMs = 10'000;
constexpr int kServerPingIntervalMs = 60'000;
constexpr int kServerPingTimeoutMs = 20'000;

constexpr char kIngestServiceName[] = "steadymap.v1.IngestService";
constexpr char kMapServiceName[] = "steadymap.v1.MapService";
constexpr char kQueryServiceName[] = "steadymap.v1.QueryService";
constexpr char kWatchServiceName[] = "steadymap.v1.WatchService";

std::size_t DecoderCount() { return std::max(2U, std::thread::hardware_concurrency()); }

}  // namespace

/// Everything that runs; declared in the order in which it is built, so that what is used outlives
/// its users.
class Server::Parts {
 public:
  Parts(const ServerConfig& config, std::unique_ptr<Store> store);

  ~Parts() { Shutdown(std::chrono::milliseconds(0)); }

  absl::Status Start();
  void Drain();
  void Shutdown(std::chrono::milliseconds deadline);

  absl::Status health() const { return store_->health(); }

  Heartbeat::Clock::time_point last_progress() const;
  void SetLimits(const LimitOptions& limits);

  int port() const { return port_; }

  grpc::Server& grpc_server() { return *grpc_server_; }

 private:
  absl::Status Listen();
  void Configure(grpc::ServerBuilder* builder);
  void UpdateHealth();

  const ServerConfig config_;
  const std::unique_ptr<Store> store_;
  LiveLimits limits_;
  FrameBudget budget_;
  UploadRoster roster_;
  WatchHub watch_hub_;
  StreamGate streams_;
  LogWriter log_writer_;
  MapDirectory maps_;
  WorkerPool decoders_;
  WorkerPool clerk_;
  WorkerPool readers_;
  WorkerPool watchers_;
  IngestService ingest_service_;
  MapService map_service_;
  QueryService query_service_;
  WatchService watch_service_;
  std::optional<Housekeeper> housekeeper_;
  int port_ = 0;
  std::unique_ptr<grpc::Server> grpc_server_;
  std::atomic<grpc::HealthCheckServiceInterface*> health_service_ = nullptr;
  std::atomic<bool> draining_ = false;
  std::atomic<bool> shut_down_ = false;
};

Server::Parts::Parts(const ServerConfig& config, std::unique_ptr<Store> store)
    : config_(config),
      store_(std::move(store)),
      limits_(config.limits),
      budget_(config.limits.queue_bytes_total),
      watch_hub_(
          {store_.get(), config.watch.max_watches, absl::FromChrono(config.watch.stall_timeout)}),
      streams_({.stall_timeout = config.watch.stall_timeout}),
      log_writer_(store_.get(), [this](const absl::Status&) { UpdateHealth(); }),
      maps_({store_.get(),
             &budget_,
             config.commit,
             config.limits.queue_bytes_per_map,
             [this](const std::shared_ptr<MapRuntime>& map) { log_writer_.Notify(map); },
             [this](MapKey map) { watch_hub_.OnCommit(map); },
             [this](const absl::Status&) { UpdateHealth(); }}),
      decoders_("decoders", DecoderCount(), kMaxWaitingBatches),
      clerk_("clerk", 1, kMaxWaitingCalls),
      readers_("readers", 2, kMaxWaitingCalls),
      watchers_("watchers", 2, config.watch.max_watches + kMaxWaitingCalls),
      ingest_service_({&maps_, &roster_, &decoders_, &limits_}),
      map_service_({&maps_, &roster_, &watch_hub_, &clerk_, config.retention}),
      query_service_({&maps_, store_.get(), &readers_, &streams_}),
      watch_service_({&maps_, &watch_hub_, &watchers_}) {}

absl::Status Server::Parts::Start() {
  if (absl::Status status = maps_.Load(); !status.ok()) return status;
  housekeeper_.emplace(&maps_, &watch_hub_, &streams_, store_.get(), config_.retention);
  if (absl::Status status = Listen(); !status.ok()) return status;
  health_service_ = grpc_server_->GetHealthCheckService();
  UpdateHealth();
  spdlog::info("serving {} maps on {}, port {}", maps_.All().size(), config_.listen, port_);
  return absl::OkStatus();
}

absl::Status Server::Parts::Listen() {
  grpc::EnableDefaultHealthCheckService(true);
  // Both register themselves with every builder of the process from then on.
  if (config_.reflection) grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  if (config_.channelz) grpc::channelz::experimental::InitChannelzService();
  grpc::ServerBuilder builder;
  Configure(&builder);
  builder.AddListeningPort(config_.listen, grpc::InsecureServerCredentials(), &port_);
  builder.RegisterService(&ingest_service_);
  builder.RegisterService(&map_service_);
  builder.RegisterService(&query_service_);
  builder.RegisterService(&watch_service_);
  grpc_server_ = builder.BuildAndStart();
  if (grpc_server_ != nullptr) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("cannot listen on ",
                                             config_.listen,
                                             ": the address is in use, not this machine's, or not "
                                             "permitted"));
}

void Server::Parts::Configure(grpc::ServerBuilder* builder) {
  builder->SetMaxReceiveMessageSize(
      static_cast<int>(kHardMessageLimitFactor * config_.limits.max_message_bytes));
  // gRPC 1.51 inflates a message before it looks at its limit: a bomb must not get that far.
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder->SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  grpc::ResourceQuota quota("steadymapd");
  quota.Resize(kTransportBytes);
  builder->SetResourceQuota(quota);
  // Otherwise two daemons share a port and take each other's calls.
  builder->AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder->AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                              kMinClientPingIntervalMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kServerPingIntervalMs);
  builder->AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kServerPingTimeoutMs);
}

void Server::Parts::UpdateHealth() {
  grpc::HealthCheckServiceInterface* health = health_service_;
  if (health == nullptr) return;
  const bool stopping = draining_;
  const bool writable = !stopping && store_->health().ok();
  health->SetServingStatus("", writable);
  health->SetServingStatus(kIngestServiceName, writable);
  health->SetServingStatus(kMapServiceName, writable);
  // What is published can be read all the same.
  health->SetServingStatus(kQueryServiceName, !stopping);
  health->SetServingStatus(kWatchServiceName, !stopping);
}

void Server::Parts::Drain() {
  if (draining_.exchange(true)) return;
  // A server that could not listen has nothing to drain, and its error should stand alone.
  if (grpc_server_ != nullptr) {
    spdlog::info("draining: {} upload streams are open", roster_.stream_count());
  }
  UpdateHealth();
  roster_.Drain();
}

// The order of the end: nobody comes in, what is under way is finished, watchers see it, calls end,
// then the threads from the first of the pipeline to the last, so that none feeds one that is gone.
void Server::Parts::Shutdown(std::chrono::milliseconds deadline) {
  if (shut_down_.exchange(true)) return;
  const absl::Time end = absl::Now() + absl::FromChrono(deadline);
  Drain();
  if (!roster_.AwaitEmpty(end)) spdlog::warn("some uploads had not ended at the deadline");
  watch_hub_.Drain();
  if (!watch_hub_.AwaitEmpty(std::min(end, absl::Now() + kGoodbyeTime))) watch_hub_.CancelAll();
  health_service_ = nullptr;
  if (grpc_server_ != nullptr) grpc_server_->Shutdown(absl::ToChronoTime(end));
  housekeeper_.reset();
  decoders_.Stop();
  clerk_.Stop();
  readers_.Stop();
  watchers_.Stop();
  log_writer_.Stop();
  maps_.Close(DrainingError());
}

Heartbeat::Clock::time_point Server::Parts::last_progress() const {
  Heartbeat::Clock::time_point oldest = log_writer_.heartbeat().last();
  for (const std::shared_ptr<MapRuntime>& map : maps_.All()) {
    if (const auto progress = map->last_progress()) oldest = std::min(oldest, *progress);
  }
  return oldest;
}

void Server::Parts::SetLimits(const LimitOptions& limits) {
  LimitOptions live = limits;
  live.max_message_bytes = config_.limits.max_message_bytes;
  limits_.Set(live);
  budget_.SetTotal(limits.queue_bytes_total);
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

absl::Status Server::health() const { return parts_->health(); }

std::chrono::steady_clock::time_point Server::last_progress() const {
  return parts_->last_progress();
}

void Server::SetLimits(const LimitOptions& limits) { parts_->SetLimits(limits); }

}  // namespace steadymap
