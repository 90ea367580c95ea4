// steadymapd: reads its configuration, opens the store and serves until a signal ends it.

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

/// Longest interval between two watchdog notifications.
constexpr std::chrono::milliseconds kLongestWait{1000};

/// Log lines from protobuf per minute.
constexpr int kProtobufLines = 10;

int Refuse(const absl::Status& status) {
  std::fprintf(stderr, "steadymapd: %s\n", std::string(status.message()).c_str());
  return kExitBadConfig;
}

// gRPC messages are written at level debug, because any client can trigger them and because the
// errors that matter to an operator are also returned as a status.
void LogForGrpc(gpr_log_func_args* record) {
  spdlog::debug("gRPC: {} ({}:{})", record->message, record->file, record->line);
}

// protobuf logs messages about malformed client data. Their rate is limited, because any client can
// trigger them.
void LogForProtobuf(google::protobuf::LogLevel /*level*/,
                    const char* file,
                    int line,
                    const std::string& message) {
  static LogLimiter limiter(kProtobufLines, std::chrono::minutes(1));
  if (!limiter.Allows(LogLimiter::Clock::now())) return;
  spdlog::warn("protobuf: {} ({}:{})", message, file, line);
}

// Each connection and each open file of a map uses a descriptor. The usual soft limit of 1024
// exists for programs that use select(2).
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t before = limit.rlim_cur;
  limit.rlim_cur = limit.rlim_max;
  if (before != limit.rlim_cur && ::setrlimit(RLIMIT_NOFILE, &limit) != 0) {
    spdlog::warn("could not raise the limit on open files; it remains {}", before);
    return;
  }
  spdlog::info("up to {} files and connections may be open", limit.rlim_cur);
}

// Must run before any other thread starts, so that the signals are blocked in every thread.
// `WaitForSignal` receives them.
sigset_t BlockSignals() {
  sigset_t signals;
  ::sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) ::sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

// Returns the next signal, or 0 after the timeout.
int WaitForSignal(const sigset_t& signals, std::chrono::milliseconds timeout) {
  const timespec wait{timeout.count() / 1000, timeout.count() % 1000 * 1'000'000};
  const int signal = ::sigtimedwait(&signals, nullptr, &wait);
  return signal > 0 ? signal : 0;
}

// Writes a new file and renames it, so that no reader sees a partial file.
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

// Handles SIGHUP: applies the reloadable settings, or keeps all settings if the file is invalid.
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

// Serves until SIGTERM or SIGINT arrives.
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
    // A hanging thread stops the progress; systemd then restarts the daemon.
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
  IntegrationNote::InstallCrashHandlers();
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
  // Programs parse this line: see the README.
  spdlog::info("listening on {}", WithPort(config.listen, server->port()));
  ServiceManagerNotifier service_manager;
  service_manager.Ready();
  Serve(signals, command_line, &config, server.get(), &service_manager);

  // Order of shutdown:
  // 1. Notify the service manager and start the exit deadline.
  service_manager.Stopping();
  const Clock::time_point end = Clock::now() + config.drain_timeout;
  const ExitDeadline deadline(config.drain_timeout);
  // 2. Report NOT_SERVING, refuse new uploads, integrate and acknowledge the accepted frames.
  server->Drain();
  // 3. End streams and calls, commit the integrated frames, join the threads. Calls are cancelled
  //    before the exit deadline, so that time is left for the commit and the joins.
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
  server->Shutdown(std::max(left * 4 / 5, std::chrono::milliseconds(0)));
  // 4. The destructors close the store and release the lock of its folder.
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
