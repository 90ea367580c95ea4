#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/client/map/fake_map_server.h"
#include "tests/client/upload/fake_ingest_service.h"
#include "tests/support/command_outcome.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {

inline grpc::Status AcceptAll(ScriptedStream& stream) {
  stream.ReadOpen();
  stream.SendOpened(0, 100'000);
  return stream.AcceptRest();
}

/// Runs commands in this process against services in this process.
class CommandLineTest : public ::testing::Test {
 protected:
  Outcome Run(const std::vector<std::string>& arguments) {
    return RunCommand(arguments, [this](const std::string& server) {
      server_asked_ = server;
      return server_.channel();
    });
  }

  /// Runs a command that must fail with one line containing `part`.
  void ExpectFailure(const std::vector<std::string>& arguments,
                     int exit_code,
                     const std::string& part) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("steadymap: ")) << outcome.err;
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
  }

  std::string PathOf(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  std::string server_asked_;
  FakeMapService maps_;
  FakeQueryService queries_;
  FakeIngestService ingest_{std::vector<FakeIngestService::Script>(8, AcceptAll)};
  FakeServer server_{&maps_, &queries_, &ingest_};
};

}  // namespace steadymap
