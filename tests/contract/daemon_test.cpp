#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

/// A daemon that must not start, and say why in one line that holds `part`; beside it there may be
/// lines of information.
void ExpectRefusal(const std::vector<std::string>& arguments,
                   const std::filesystem::path& folder,
                   const std::string& part) {
  std::filesystem::remove(folder / "steadymapd.log");
  const ProcessEnd end = RunDaemon(arguments, folder);
  EXPECT_NE(end.exit_code, 0);
  EXPECT_LT(end.exit_code, 128) << "ended by a signal";
  std::istringstream stream(end.errors);
  std::vector<std::string> complaints;
  for (std::string line; std::getline(stream, line);) {
    if (line.find("Z info ") == std::string::npos) complaints.push_back(line);
  }
  ASSERT_EQ(complaints.size(), 1U) << end.errors;
  EXPECT_NE(complaints[0].find(part), std::string::npos) << complaints[0];
}

TEST(Steadymapd, TerminationIsACleanExit) {
  const TemporaryFolder folder;
  DaemonProcess daemon(folder.path());
  daemon.AwaitServing();
  const ProcessEnd end = daemon.Terminate();
  EXPECT_EQ(end.exit_code, 0) << end.errors;
}

TEST(Steadymapd, StartsAgainAfterItWasKilled) {
  const TemporaryFolder folder;
  DaemonProcess daemon(folder.path());
  daemon.Kill();
  daemon.Restart();
  daemon.AwaitServing();
  EXPECT_EQ(daemon.Terminate().exit_code, 0);
}

TEST(Steadymapd, APortInUseIsAnErrorOfOneLine) {
  const TemporaryFolder folder;
  const TemporaryFolder other;
  const DaemonProcess daemon(folder.path());
  ExpectRefusal({"--listen", daemon.address(), "--data-dir", (other.path() / "data").string()},
                other.path(),
                daemon.address());
  daemon.AwaitServing();
}

TEST(Steadymapd, AStoreInUseIsAnErrorOfOneLine) {
  const TemporaryFolder folder;
  const TemporaryFolder other;
  const DaemonProcess daemon(folder.path());
  const std::string data = (folder.path() / "data").string();
  ExpectRefusal({"--listen", "localhost:0", "--data-dir", data}, other.path(), data);
  daemon.AwaitServing();
}

TEST(Steadymapd, AFolderThatCannotBeMadeIsAnErrorOfOneLine) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "not a folder";
  const std::string data = (folder.path() / "file" / "data").string();
  ExpectRefusal({"--listen", "localhost:0", "--data-dir", data}, folder.path(), data);
}

TEST(Steadymapd, AGarbageConfigurationIsAnErrorOfOneLine) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "steadymap.toml";
  std::ofstream(file) << "listen = \"localhost:0\"\nvoxels = = 3\n";
  ExpectRefusal({"--config", file.string()}, folder.path(), "steadymap.toml");
  std::ofstream(file) << "no_such_key = 3\n";
  ExpectRefusal({"--config", file.string()}, folder.path(), "no_such_key");
  ExpectRefusal(
      {"--config", (folder.path() / "missing.toml").string()}, folder.path(), "missing.toml");
}

}  // namespace
}  // namespace steadymap
