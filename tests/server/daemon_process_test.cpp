// Tests the interface of steadymapd to an operator: arguments, exit codes, messages, signals.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/command_line.h"
#include "server/config/config_file.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A steadymapd with combined stdout and stderr.
class ObservedDaemon {
 public:
  explicit ObservedDaemon(std::vector<std::string> arguments) {
    int ends[2] = {-1, -1};
    if (::pipe(ends) != 0) return;
    arguments.insert(arguments.begin(), STEADYMAPD);
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    child_ = ::fork();
    if (child_ == 0) {
      ::dup2(ends[1], STDOUT_FILENO);
      ::dup2(ends[1], STDERR_FILENO);
      ::close(ends[0]);
      ::close(ends[1]);
      ::execv(STEADYMAPD, pointers.data());
      ::_exit(127);
    }
    ::close(ends[1]);
    output_ = ::fdopen(ends[0], "r");
  }

  ~ObservedDaemon() {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(child_, nullptr, 0);
    }
    if (output_ != nullptr) std::fclose(output_);
  }

  ObservedDaemon(const ObservedDaemon&) = delete;
  ObservedDaemon& operator=(const ObservedDaemon&) = delete;

  /// Reads lines until one contains `text`; returns false if the daemon ends before.
  bool WaitFor(const std::string& text) {
    while (const std::optional<std::string> line = ReadLine()) {
      if (line->find(text) != std::string::npos) return true;
    }
    return false;
  }

  void Signal(int signal) { ::kill(child_, signal); }

  /// Reads to the end; returns the exit code, or minus the signal that ended the process.
  int Wait() {
    while (ReadLine()) {
    }
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  /// All output so far.
  const std::string& said() const { return said_; }

 private:
  std::optional<std::string> ReadLine() {
    std::string line;
    for (int c = std::fgetc(output_); c != EOF; c = std::fgetc(output_)) {
      line += static_cast<char>(c);
      if (c == '\n') break;
    }
    said_ += line;
    return line.empty() ? std::nullopt : std::optional(line);
  }

  pid_t child_ = -1;
  std::FILE* output_ = nullptr;
  std::string said_;
};

class Steadymapd : public ::testing::Test {
 protected:
  std::vector<std::string> Arguments(const std::string& listen = "127.0.0.1:0") const {
    return {"--listen", listen, "--data-dir", (folder_.path() / "data").string()};
  }

  /// Expects that these arguments lead to this exit code and one error message in the last line. A
  /// service manager restarts a daemon that exits with 1, but not one that exits with 78.
  void ExpectRefusal(const std::vector<std::string>& arguments,
                     const std::string& reason,
                     int exit_code = kExitBadConfig) {
    ObservedDaemon daemon(arguments);
    EXPECT_EQ(daemon.Wait(), exit_code);
    std::istringstream lines(daemon.said());
    std::vector<std::string> complaints;
    for (std::string line; std::getline(lines, line);) {
      if (line.find(" info ") == std::string::npos) complaints.push_back(line);
    }
    EXPECT_THAT(complaints, ElementsAre(HasSubstr(reason))) << daemon.said();
  }

  TemporaryFolder folder_;
};

TEST_F(Steadymapd, PrintsItsVersion) {
  ObservedDaemon daemon({"--version"});
  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_THAT(daemon.said(), StartsWith("steadymapd "));
}

TEST_F(Steadymapd, PrintsTheConfigurationThatIsInForce) {
  std::ofstream(folder_.path() / "config.toml") << "channelz = true\nlisten = \"localhost:5\"\n";
  ObservedDaemon daemon({"--config",
                         (folder_.path() / "config.toml").string(),
                         "--listen",
                         "localhost:6",
                         "--print-config"});
  EXPECT_EQ(daemon.Wait(), 0);
  const absl::StatusOr<ServerConfig> printed = ParseConfig(daemon.said(), "printed");
  ASSERT_TRUE(printed.ok()) << printed.status();
  EXPECT_TRUE(printed->channelz);
  EXPECT_EQ(printed->listen, "localhost:6") << "flags override the file";
}

TEST_F(Steadymapd, RefusesWhatItCannotRunWith) {
  ExpectRefusal({"--bogus"}, "--bogus");
  ExpectRefusal({"--config", (folder_.path() / "none.toml").string()}, "none.toml");
  std::ofstream(folder_.path() / "bad.toml") << "[limits]\nmax_mesage_bytes = 1\n";
  ExpectRefusal({"--config", (folder_.path() / "bad.toml").string()},
                "bad.toml:2:1: unknown key limits.max_mesage_bytes");
  ExpectRefusal({"--listen", "0.0.0.0:0"}, "allow_plaintext_remote");
  ExpectRefusal({"--listen", "nonsense"}, "listen must read HOST:PORT");
  ExpectRefusal(
      {"--listen", "127.0.0.1:0", "--data-dir", (folder_.path() / "bad.toml" / "data").string()},
      "cannot write to data folder",
      kExitFailure);
}

TEST_F(Steadymapd, ServesWritesItsPortAndStopsCleanlyOnSigterm) {
  std::vector<std::string> arguments = Arguments();
  const std::filesystem::path port_file = folder_.path() / "port";
  arguments.insert(arguments.end(), {"--port-file", port_file.string()});
  ObservedDaemon daemon(arguments);
  ASSERT_TRUE(daemon.WaitFor("listening on 127.0.0.1:")) << daemon.said();
  int port = 0;
  std::ifstream(port_file) >> port;
  EXPECT_GT(port, 0);
  EXPECT_THAT(daemon.said(), HasSubstr("listening on 127.0.0.1:" + std::to_string(port) + "\n"));
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.said();
  EXPECT_THAT(daemon.said(), HasSubstr("stopped"));
}

TEST_F(Steadymapd, RefusesAPortAndAFolderThatAreInUse) {
  std::vector<std::string> arguments = Arguments();
  const std::filesystem::path port_file = folder_.path() / "port";
  arguments.insert(arguments.end(), {"--port-file", port_file.string()});
  ObservedDaemon first(arguments);
  ASSERT_TRUE(first.WaitFor("listening on")) << first.said();
  ExpectRefusal(Arguments(), "is held by another steadymapd", kExitFailure);
  std::string port;
  std::ifstream(port_file) >> port;
  const std::vector<std::string> same_port = {
      "--listen", "127.0.0.1:" + port, "--data-dir", (folder_.path() / "b").string()};
  ExpectRefusal(same_port, "127.0.0.1:" + port, kExitFailure);
  ObservedDaemon second(same_port);
  EXPECT_EQ(second.Wait(), 1);
  EXPECT_EQ(second.said().find("draining"), std::string::npos) << "it has nothing to drain";
}

TEST_F(Steadymapd, ReloadsOnSighupAndKeepsWhatItHasIfTheFileIsWrong) {
  const std::filesystem::path config = folder_.path() / "config.toml";
  std::ofstream(config) << "";
  std::vector<std::string> arguments = Arguments();
  arguments.insert(arguments.end(), {"--config", config.string()});
  ObservedDaemon daemon(arguments);
  ASSERT_TRUE(daemon.WaitFor("listening on")) << daemon.said();
  std::ofstream(config) << "[commit]\nmax_frames = 0\n";
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitFor("configuration not reloaded: commit.max_frames must lie in"));
  std::ofstream(config) << "[limits]\nupload_window_frames = 3\n[commit]\nmax_frames = 8\n";
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitFor("reloaded: limits.upload_window_frames: 64 -> 3"));
  EXPECT_TRUE(daemon.WaitFor("not reloaded, a restart is needed: commit.max_frames: 32 -> 8"));
  std::ofstream(config) << "[limits]\nupload_window_frames = 3\n";
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitFor("configuration reloaded: nothing changed"));
  daemon.Signal(SIGINT);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.said();
}

TEST_F(Steadymapd, ChecksAStoreThatNobodyServes) {
  const std::string data = (folder_.path() / "data").string();
  const std::vector<std::string> check = {"check", "--data-dir", data};
  {
    ObservedDaemon none(check);
    EXPECT_EQ(none.Wait(), kExitCannotRun) << "there is no store";
    ObservedDaemon daemon(Arguments());
    ASSERT_TRUE(daemon.WaitFor("listening on")) << daemon.said();
    ObservedDaemon beside(check);
    EXPECT_EQ(beside.Wait(), kExitCannotRun);
    EXPECT_THAT(beside.said(), HasSubstr("is held by another steadymapd"));
    daemon.Signal(SIGTERM);
    EXPECT_EQ(daemon.Wait(), 0);
  }
  ObservedDaemon whole(check);
  EXPECT_EQ(whole.Wait(), 0) << whole.said();
  std::filesystem::remove(folder_.path() / "data" / "schema.copy");
  ObservedDaemon damaged(check);
  EXPECT_EQ(damaged.Wait(), kExitFailure);
  EXPECT_THAT(damaged.said(), HasSubstr("schema.copy"));
  ObservedDaemon salvage({"salvage", "--data-dir", data, "--map", "acme/none"});
  EXPECT_EQ(salvage.Wait(), kExitCannotRun);
  EXPECT_THAT(salvage.said(), HasSubstr("there is no map tenants/acme/maps/none"));
}

TEST_F(Steadymapd, RaisesItsLimitOfOpenFiles) {
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
  const rlimit low{std::min<rlim_t>(256, limit.rlim_max), limit.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &low), 0);
  ObservedDaemon daemon(Arguments());
  EXPECT_TRUE(daemon.WaitFor("up to " + std::to_string(limit.rlim_max) + " files"));
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
}

TEST_F(Steadymapd, JsonLogHoldsOneObjectALine) {
  std::ofstream(folder_.path() / "config.toml") << "log.format = \"json\"\n";
  std::vector<std::string> arguments = Arguments();
  arguments.insert(arguments.end(), {"--config", (folder_.path() / "config.toml").string()});
  ObservedDaemon daemon(arguments);
  ASSERT_TRUE(daemon.WaitFor("\"message\":\"listening on 127.0.0.1:")) << daemon.said();
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  std::istringstream lines(daemon.said());
  for (std::string line; std::getline(lines, line);) {
    EXPECT_THAT(line, StartsWith("{\"time\":\""));
    EXPECT_EQ(line.back(), '}');
  }
}

}  // namespace
}  // namespace steadymap
