#pragma once

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/channel.h"
#include "client/cli/command_line.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {

/// What a command printed and returned.
struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;
};

/// The command line, in process, against the daemon in a process of its own.
class CliTest : public ::testing::Test {
 protected:
  Outcome Run(std::vector<std::string> arguments) const {
    std::ostringstream out;
    std::ostringstream err;
    CommandContext context{.out = out, .err = err};
    context.open_channel = OpenChannel;
    arguments.insert(arguments.begin(), {"--server", daemon_.address()});
    const int exit_code = RunCommandLine(arguments, &context);
    return {exit_code, out.str(), err.str()};
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
