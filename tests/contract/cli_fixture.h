#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/transport/channel.h"
#include "tests/support/command_outcome.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {

/// The command line, in this process, against a daemon in its own process.
class CliTest : public ::testing::Test {
 protected:
  Outcome Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"--server", daemon_.address()});
    return RunCommand(arguments, OpenChannel);
  }

  void ExpectFailure(const std::vector<std::string>& arguments, const std::string& part) const {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
  }

  std::string PathOf(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  DaemonProcess daemon_{folder_.path()};
};

}  // namespace steadymap
