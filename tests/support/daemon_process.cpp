#include "tests/support/daemon_process.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/security/credentials.h>
#include <poll.h>
#include <spawn.h>
#include <sys/inotify.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/descriptor.h"

namespace steadymap {
namespace {

// Much more than any start takes; reached only if a daemon hangs.
constexpr std::chrono::seconds kStartLimit{30};

std::runtime_error SystemError(const char* what) {
  return std::runtime_error(std::string(what) + ": " + std::generic_category().message(errno));
}

std::string ContentOfFile(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// Starts steadymapd with standard error appended to `log`. The child inherits `life_line`, a pipe
// without data: its other end receives a hang-up when the child ends.
pid_t Spawn(std::vector<std::string> arguments, const std::filesystem::path& log, int life_line) {
  arguments.insert(arguments.begin(), STEADYMAPD);
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(
      &actions, STDERR_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&actions, life_line, STDERR_FILENO + 1);
  pid_t process = -1;
  const int error = posix_spawn(&process, STEADYMAPD, &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw std::runtime_error(std::string(STEADYMAPD) + ": " +
                             std::generic_category().message(error));
  }
  return process;
}

int WaitForEnd(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) throw SystemError("waitpid");
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// Calls Health/Check for the whole server. Without a packaged health.proto: an empty request means
// the server, and a response with status SERVING is field 1 with the value 1.
bool IsServing(grpc::GenericStub* stub, std::chrono::system_clock::time_point deadline) {
  grpc::ClientContext context;
  context.set_deadline(deadline);
  context.set_wait_for_ready(true);
  grpc::CompletionQueue queue;
  const auto call = stub->PrepareUnaryCall(
      &context, "/grpc.health.v1.Health/Check", grpc::ByteBuffer(nullptr, 0), &queue);
  call->StartCall();
  grpc::ByteBuffer answer;
  grpc::Status status;
  call->Finish(&answer, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  grpc::Slice bytes;
  if (!status.ok() || !answer.DumpToSingleSlice(&bytes).ok()) return false;
  return std::string(reinterpret_cast<const char*>(bytes.begin()), bytes.size()) == "\x08\x01";
}

}  // namespace

DaemonProcess::DaemonProcess(std::filesystem::path folder) : folder_(std::move(folder)) {
  Start("127.0.0.1:0");
  address_ = "127.0.0.1:" + ContentOfFile(folder_ / "port");
  address_.erase(address_.find_last_not_of('\n') + 1);
}

DaemonProcess::~DaemonProcess() { Kill(); }

void DaemonProcess::Kill() {
  if (process_ < 0) return;
  kill(process_, SIGKILL);
  WaitForEnd(process_);
  process_ = -1;
}

ProcessEnd DaemonProcess::Terminate() {
  kill(process_, SIGTERM);
  const int exit_code = WaitForEnd(process_);
  process_ = -1;
  return {exit_code, Log()};
}

void DaemonProcess::Restart() { Start(address_); }

void DaemonProcess::Start(const std::string& listen) {
  std::filesystem::remove(folder_ / "port");
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw SystemError("pipe2");
  const Descriptor life_line(ends[0]);
  Descriptor inherited(ends[1]);
  started_ = std::chrono::steady_clock::now();
  process_ = Spawn({"--listen",
                    listen,
                    "--data-dir",
                    (folder_ / "data").string(),
                    "--port-file",
                    (folder_ / "port").string()},
                   folder_ / "steadymapd.log",
                   inherited.number());
  inherited.Close();
  AwaitPortFile(life_line.number());
}

void DaemonProcess::AwaitPortFile(int life_line) const {
  const Descriptor watch(inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  if (inotify_add_watch(watch.number(), folder_.c_str(), IN_MOVED_TO | IN_CLOSE_WRITE) < 0) {
    throw SystemError("inotify_add_watch");
  }
  while (!std::filesystem::exists(folder_ / "port")) {
    const auto left = kStartLimit - (std::chrono::steady_clock::now() - started_);
    const auto left_ms = std::chrono::duration_cast<std::chrono::milliseconds>(left).count();
    std::array<pollfd, 2> events{pollfd{watch.number(), POLLIN, 0}, pollfd{life_line, POLLIN, 0}};
    const int count =
        left_ms > 0 ? poll(events.data(), events.size(), static_cast<int>(left_ms)) : 0;
    if (count < 0 && errno != EINTR) throw SystemError("poll");
    if (count == 0 || (events[1].revents & POLLHUP) != 0) {
      throw std::runtime_error("steadymapd did not start: " + Log());
    }
    std::array<char, 4096> drained{};
    while (read(watch.number(), drained.data(), drained.size()) > 0) {
    }
  }
}

std::chrono::duration<double> DaemonProcess::AwaitServing() const {
  grpc::GenericStub stub(grpc::CreateChannel(address_, grpc::InsecureChannelCredentials()));
  const auto limit = std::chrono::system_clock::now() + kStartLimit;
  while (!IsServing(&stub, limit)) {
    if (std::chrono::system_clock::now() > limit) {
      throw std::runtime_error("steadymapd did not serve: " + Log());
    }
  }
  return std::chrono::steady_clock::now() - started_;
}

std::string DaemonProcess::Log() const { return ContentOfFile(folder_ / "steadymapd.log"); }

}  // namespace steadymap
