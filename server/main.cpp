// steadymapd: reads its configuration, opens the store, serves until it is told to stop.

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include "core/types/parallel.h"
#include "server/command_line.h"
#include "server/config/config_file.h"
#include "server/process/exit_deadline.h"
#include "server/process/log_limiter.h"
#include "server/process/logging.h"
#include "server/process/service_manager_notifier.h"
#include "server/process/worker_pool.h"
#include "server/server.h"
#include "server/store/model/integration_note.h"
#include "server/store/model/store.h"
#include "server/store_tools.h"

namespace steadymap {
namespace {

using Clock = std::chrono::steady_clock;

/// How often the daemon looks after itself, at most.
constexpr std::chrono::milliseconds kLongestWait{1000};

/// Lines of protobuf's in a minute.
constexpr int kProtobufLines = 10;

int Refuse(const absl::Status& status) {
  std::fprintf(stderr, "steadymapd: %s\n", std::string(status.message()).c_str());
  return kExitBadConfig;
}

// What gRPC says goes where everything goes, for those who debug: any client can make it talk, and
// what matters to an operator comes back to us as a status.
void LogForGrpc(gpr_log_func_args* record) {
  spdlog::debug("gRPC: {} ({}:{})", record->message, record->file, record->line);
}

// What protobuf says of messages that clients send, a few lines of it: any client can make it talk.
void LogForProtobuf(google::protobuf::LogLevel /*level*/,
                    const char* file,
                    int line,
                    const std::string& message) {
  static LogLimiter limiter(kProtobufLines, std::chrono::minutes(1));
  if (!limiter.Allows(LogLimiter::Clock::now())) return;
  spdlog::warn("protobuf: {} ({}:{})", message, file, line);
}

// Every connection and every open file of a map takes a descriptor; the usual soft limit of 1024 is
// for programs that use select(2).
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t before = limit.rlim_cur;
  limit.rlim_cur = limit.rlim_max;
  if (before != limit.rlim_cur && ::setrlimit(RLIMIT_NOFILE, &limit) != 0) {
    spdlog::warn("the limit of open files stays at {}", before);
    return;
  }
  spdlog::info("up to {} files and connections may be open", limit.rlim_cur);
}

// Blocked in every thread, since this is called before there are others; `WaitForSignal` takes
// them.
sigset_t BlockSignals() {
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// The next of the signals, or 0 when there was none in time.
int WaitForSignal(const sigset_t& signals, std::chrono::milliseconds timeout) {
  const timespec wait{timeout.count() / 1000, timeout.count() % 1000 * 1'000'000};
  const int signal = ::sigtimedwait(&signals, nullptr, &wait);
  return signal > 0 ? signal : 0;
}

// Whoever waits for the file never sees half of it.
absl::Status WritePortFile(const std::filesystem::path& file, int port) {
  const std::filesystem::path fresh = file.string() + ".new";
  {
    std::ofstream stream(fresh);
    stream << port << '\n';
    if (!stream.flush()) return absl::NotFoundError("cannot write port file " + fresh.string());
  }
  std::error_code error;
  std::filesystem::rename(fresh, file, error);
  if (!error) return absl::OkStatus();
  return absl::NotFoundError("cannot write port file " + file.string() + ": " + error.message());
}

// SIGHUP: takes over what may change, or keeps everything if the file is wrong.
void Reload(const CommandLine& command_line, ServerConfig* config, Server* server) {
  absl::StatusOr<ServerConfig> fresh = ReadConfig(command_line);
  absl::Status status = fresh.ok() ? ValidateServerConfig(*fresh) : fresh.status();
  if (!status.ok()) {
    spdlog::error("configuration not reloaded: {}", std::string(status.message()));
    return;
  }
  const ServerConfig before = *config;
  ApplyReloadable(*fresh, config);
  SetLogLevel(config->log.level);
  server->SetLimits(config->limits);
  const std::vector<std::string> applied = FindDifferences(before, *config);
  const std::vector<std::string> waiting = FindDifferences(*config, *fresh);
  for (const std::string& change : applied) spdlog::info("configuration reloaded: {}", change);
  for (const std::string& change : waiting) {
    spdlog::warn("configuration not reloaded, a restart is needed: {}", change);
  }
  if (applied.empty() && waiting.empty()) spdlog::info("configuration reloaded: nothing changed");
}

// Serves until a signal ends it.
void Serve(const sigset_t& signals,
           const CommandLine& command_line,
           ServerConfig* config,
           Server* server,
           ServiceManagerNotifier* service_manager) {
  const std::chrono::microseconds watchdog =
      service_manager->watchdog_interval().value_or(kLongestWait * 4);
  const auto wait = std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(watchdog / 4),
                               std::chrono::milliseconds(1),
                               kLongestWait);
  while (true) {
    const int signal = WaitForSignal(signals, wait);
    if (signal == SIGTERM || signal == SIGINT) {
      spdlog::info("{} received, draining", signal == SIGTERM ? "SIGTERM" : "SIGINT");
      return;
    }
    if (signal == SIGHUP) {
      service_manager->Reloading();
      Reload(command_line, config, server);
      service_manager->Ready();
    }
    IntegrationNote::AgeAll();
    // A thread that hangs stops the progress, and then systemd restarts the daemon.
    if (Clock::now() - server->last_progress() < watchdog) service_manager->FeedWatchdog();
  }
}

int Run(const CommandLine& command_line, ServerConfig config) {
  StartLogging(config.log);
  ::gpr_set_log_function(LogForGrpc);
  google::protobuf::SetLogHandler(LogForProtobuf);
  RaiseDescriptorLimit();
  std::signal(SIGPIPE, SIG_IGN);
  const sigset_t signals = BlockSignals();
  IntegrationNote::CatchCrashes();
  SetHelperThreadHook([] { NameThread("compute"); });
  absl::StatusOr<std::unique_ptr<Store>> store = Store::Open(config.data_dir, config.store);
  if (!store.ok()) {
    spdlog::error("{}", std::string(store.status().message()));
    return EXIT_FAILURE;
  }
  absl::StatusOr<std::unique_ptr<Server>> started = Server::Start(config, *std::move(store));
  if (!started.ok()) {
    spdlog::error("{}", std::string(started.status().message()));
    return EXIT_FAILURE;
  }
  const std::unique_ptr<Server> server = *std::move(started);
  if (!command_line.port_file.empty()) {
    if (absl::Status status = WritePortFile(command_line.port_file, server->port()); !status.ok()) {
      spdlog::error("{}", std::string(status.message()));
      return EXIT_FAILURE;
    }
  }
  // Programs look for this line: see the README.
  spdlog::info("listening on {}", WithPort(config.listen, server->port()));
  ServiceManagerNotifier service_manager;
  service_manager.Ready();
  Serve(signals, command_line, &config, server.get(), &service_manager);

  // The order of shutdown:
  // 1. The service manager learns of it, and the time starts to run.
  service_manager.Stopping();
  const Clock::time_point end = Clock::now() + config.drain_timeout;
  const ExitDeadline deadline(config.drain_timeout);
  // 2. Health says NOT_SERVING, no new uploads; what was taken is integrated and acknowledged.
  server->Drain();
  // 3. Streams and calls end, what is integrated is committed, threads are joined. Some of the time
  //    is left for that: calls are cancelled before it is over.
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
  server->Shutdown(std::max(left * 4 / 5, std::chrono::milliseconds(0)));
  // 4. On return the store is closed and the folder let go.
  return EXIT_SUCCESS;
}

int Main(int argument_count, const char* const* arguments) {
  const CommandLine command_line = ParseCommandLine(argument_count, arguments);
  if (command_line.exit_code) return *command_line.exit_code;
  const absl::StatusOr<ServerConfig> config = ReadConfig(command_line);
  if (!config.ok()) return Refuse(config.status());
  if (absl::Status status = ValidateServerConfig(*config); !status.ok()) return Refuse(status);
  if (command_line.print_config) {
    std::fputs(PrintConfig(*config).c_str(), stdout);
    return EXIT_SUCCESS;
  }
  if (command_line.command != Command::kServe) return RunStoreTool(command_line, *config);
  const int exit_code = Run(command_line, *config);
  if (exit_code == EXIT_SUCCESS) spdlog::info("stopped");
  return exit_code;
}

}  // namespace
}  // namespace steadymap

int main(int argument_count, char** arguments) {
  try {
    return steadymap::Main(argument_count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "steadymapd: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
