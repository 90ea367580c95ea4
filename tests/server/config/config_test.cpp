#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/config/config_file.h"
#include "server/config/server_config.h"
#include "server/process/log_limiter.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

std::string ErrorOf(const std::string& text) {
  const absl::StatusOr<ServerConfig> config = ParseConfig(text, "steadymap.toml");
  EXPECT_EQ(config.status().code(), absl::StatusCode::kInvalidArgument) << text;
  return std::string(config.status().message());
}

TEST(ParseConfig, EmptyFileGivesTheDefaults) {
  EXPECT_EQ(PrintConfig(ParseConfig("", "empty").value()), PrintConfig(ServerConfig()));
}

TEST(ParseConfig, TakesEveryKindOfField) {
  const absl::StatusOr<ServerConfig> config = ParseConfig(R"(
listen = "127.0.0.1:0"
channelz = true
drain_timeout_s = 12
log.level = "debug"
[limits]
max_message_bytes = 1_048_576
[commit]
max_delay_ms = 100
)",
                                                          "steadymap.toml");
  ASSERT_TRUE(config.ok()) << config.status();
  EXPECT_EQ(config->listen, "127.0.0.1:0");
  EXPECT_TRUE(config->channelz);
  EXPECT_EQ(config->drain_timeout, std::chrono::seconds(12));
  EXPECT_EQ(config->log.level, LogLevel::kDebug);
  EXPECT_EQ(config->limits.max_message_bytes, std::size_t{1} << 20);
  EXPECT_EQ(config->commit.max_delay, std::chrono::milliseconds(100));
  EXPECT_EQ(config->commit.max_frames, CommitOptions().max_frames);
}

TEST(ParseConfig, NamesUnknownKeysWithLineAndColumn) {
  EXPECT_EQ(ErrorOf("listen = \"localhost:1\"\n  lisen = \"x\"\n"),
            "steadymap.toml:2:3: unknown key lisen");
  EXPECT_EQ(ErrorOf("[limits]\nmax_frame_bytes = 3\n"),
            "steadymap.toml:2:1: unknown key limits.max_frame_bytes");
  EXPECT_EQ(ErrorOf("[limit]\nmax_message_bytes = 3\n"), "steadymap.toml:1:2: unknown key limit");
  EXPECT_EQ(ErrorOf("[log.sink]\nfile = \"x\"\n"), "steadymap.toml:1:6: unknown key log.sink");
}

TEST(ParseConfig, NamesWrongTypesWithLineAndColumn) {
  EXPECT_EQ(ErrorOf("listen = 7443"), "steadymap.toml:1:10: listen must be a string");
  EXPECT_EQ(ErrorOf("channelz = 1"), "steadymap.toml:1:12: channelz must be true or false");
  EXPECT_EQ(ErrorOf("drain_timeout_s = 1.5"),
            "steadymap.toml:1:19: drain_timeout_s must be an integer");
  EXPECT_EQ(ErrorOf("[log]\nformat = \"xml\""),
            "steadymap.toml:2:10: log.format must be one of \"text\", \"json\"");
  EXPECT_EQ(ErrorOf("limits = 3"), "steadymap.toml:1:10: limits must be a table");
}

TEST(ParseConfig, ReportsEverythingThatIsWrongAtOnce) {
  const std::string error = ErrorOf("a = 1\nchannelz = 2\n[log]\nb = 3\n");
  EXPECT_THAT(error, HasSubstr(":1:1: unknown key a"));
  EXPECT_THAT(error, HasSubstr(":2:12: channelz must be true or false"));
  EXPECT_THAT(error, HasSubstr(":4:1: unknown key log.b"));
}

TEST(ParseConfig, GarbageIsOneSyntaxErrorWithItsPlace) {
  EXPECT_THAT(ErrorOf("listen = \n"), StartsWith("steadymap.toml:1:"));
  EXPECT_THAT(ErrorOf(std::string("\x7F"
                                  "ELF\x02\x01\0\0\xFF\xFE",
                                  10)),
              StartsWith("steadymap.toml:1:"));
  EXPECT_THAT(ErrorOf("a = 1\na = 2\n"), StartsWith("steadymap.toml:2:"));
  ErrorOf("limits.max_message_bytes = 99999999999999999999");
}

TEST(LoadConfigFile, NamesAFileThatIsNotThere) {
  const TemporaryFolder folder;
  const absl::Status status = LoadConfigFile(folder.path() / "none.toml").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("none.toml"));
  EXPECT_EQ(LoadConfigFile(folder.path()).status().code(), absl::StatusCode::kNotFound);
}

TEST(PrintConfig, IsReadBackAsItWas) {
  std::mt19937 random(11);
  for (int i = 0; i < 200; ++i) {
    ServerConfig config;
    config.data_dir.resize(random() % 20);
    for (char& byte : config.data_dir) byte = static_cast<char>(random() % 128);
    config.channelz = random() % 2 == 0;
    config.log.level = static_cast<LogLevel>(random() % 4);
    config.log.format = static_cast<LogFormat>(random() % 2);
    config.drain_timeout = std::chrono::seconds(random());
    config.retention.frame_log_bytes = random();
    config.store.kept_poses = random();
    const std::string printed = PrintConfig(config);
    const absl::StatusOr<ServerConfig> again = ParseConfig(printed, "printed");
    ASSERT_TRUE(again.ok()) << again.status() << printed;
    EXPECT_EQ(again->data_dir, config.data_dir);
    EXPECT_EQ(PrintConfig(*again), printed);
  }
}

TEST(PrintConfig, OfTheDefaultsIsTheFileThatIsShipped) {
  std::ifstream file(std::filesystem::path(STEADYMAP_SOURCE_DIR) / "deploy" / "steadymap.toml");
  const std::string shipped((std::istreambuf_iterator<char>(file)),
                            std::istreambuf_iterator<char>());
  EXPECT_EQ(shipped, PrintConfig(ServerConfig()))
      << "write it anew: steadymapd --print-config > deploy/steadymap.toml";
}

TEST(FindViolations, DefaultsHaveNone) {
  EXPECT_THAT(FindViolations(ServerConfig()), IsEmpty());
  EXPECT_TRUE(ValidateServerConfig(ServerConfig()).ok());
}

TEST(FindViolations, ReportsAllAtOnceWithNameRangeAndValue) {
  ServerConfig config;
  config.drain_timeout = std::chrono::seconds(0);
  config.limits.upload_window_bytes = std::size_t{1} << 20;
  config.data_dir = "";
  EXPECT_THAT(FindViolations(config),
              ElementsAre("drain_timeout_s must lie in [1, 3600], got 0",
                          "data_dir must name a folder, got \"\"",
                          "limits.upload_window_bytes must be at least limits.max_message_bytes "
                          "(8388608), got 1048576"));
  EXPECT_EQ(ValidateServerConfig(config).code(), absl::StatusCode::kInvalidArgument);
}

TEST(FindViolations, NegativeNumbersOfTheFileAreOutOfRange) {
  const ServerConfig config =
      ParseConfig("[commit]\nmax_frames = -1\nmax_delay_ms = -5\n", "x").value();
  EXPECT_THAT(FindViolations(config),
              ElementsAre("commit.max_frames must lie in [1, 10000], got -1",
                          "commit.max_delay_ms must lie in [1, 60000], got -5"));
}

TEST(FindViolations, ReserveOfTheDiskMustHoldTheWriteBuffers) {
  ServerConfig config;
  config.store.write_buffer_bytes = std::size_t{16} << 20;
  config.store.min_free_disk_bytes = std::uint64_t{48} << 20;
  EXPECT_THAT(FindViolations(config), IsEmpty());
  --config.store.min_free_disk_bytes;
  EXPECT_THAT(FindViolations(config),
              ElementsAre(StartsWith("store.min_free_disk_bytes must be at least 3 times "
                                     "store.write_buffer_bytes (3 x 16777216), got 50331647")));
}

TEST(FindDifferences, NamesEachFieldWithBothValues) {
  ServerConfig after;
  EXPECT_THAT(FindDifferences(ServerConfig(), after), IsEmpty());
  after.channelz = true;
  after.log.format = LogFormat::kJson;
  after.commit.max_frames = 7;
  EXPECT_THAT(
      FindDifferences(ServerConfig(), after),
      ElementsAre(
          "channelz: false -> true", "log.format: text -> json", "commit.max_frames: 32 -> 7"));
}

TEST(LogLimiter, LetsSomeLinesThroughInEachInterval) {
  LogLimiter limiter(2, std::chrono::seconds(10));
  const LogLimiter::Clock::time_point start{std::chrono::hours(5)};
  EXPECT_TRUE(limiter.Allows(start));
  EXPECT_TRUE(limiter.Allows(start + std::chrono::seconds(9)));
  EXPECT_FALSE(limiter.Allows(start + std::chrono::seconds(9)));
  EXPECT_TRUE(limiter.Allows(start + std::chrono::seconds(10)));
}

TEST(FindViolations, ListenMustNameHostAndPort) {
  ServerConfig config;
  for (const char* listen : {"",
                             "localhost",
                             "localhost:",
                             ":7443",
                             "localhost:x",
                             "localhost:65536",
                             "localhost:-1",
                             "::1:7443",
                             "[]:1",
                             "unix:"}) {
    config.listen = listen;
    EXPECT_THAT(FindViolations(config), ElementsAre(StartsWith("listen must read HOST:PORT")))
        << listen;
  }
}

TEST(FindViolations, PlainTextForOthersMustBeAskedFor) {
  ServerConfig config;
  for (const char* listen :
       {"0.0.0.0:7443", "[::]:7443", "robot.example:1", "127.evil.example:1"}) {
    config.listen = listen;
    config.allow_plaintext_remote = false;
    EXPECT_THAT(FindViolations(config), ElementsAre(HasSubstr("allow_plaintext_remote"))) << listen;
    config.allow_plaintext_remote = true;
    EXPECT_THAT(FindViolations(config), IsEmpty()) << listen;
  }
  config.allow_plaintext_remote = false;
  for (const char* listen :
       {"localhost:0", "127.0.0.1:1", "127.1.2.3:9", "[::1]:5", "unix:/run/x"}) {
    config.listen = listen;
    EXPECT_THAT(FindViolations(config), IsEmpty()) << listen;
  }
}

TEST(ApplyReloadable, TakesLimitsAndLevelAndNothingElse) {
  ServerConfig fresh;
  fresh.listen = "localhost:1";
  fresh.log = {LogLevel::kDebug, LogFormat::kJson};
  fresh.limits.upload_window_frames = 3;
  fresh.limits.max_message_bytes = 1 << 20;
  fresh.drain_timeout = std::chrono::seconds(7);
  ServerConfig running;
  ApplyReloadable(fresh, &running);
  EXPECT_EQ(running.log.level, LogLevel::kDebug);
  EXPECT_EQ(running.limits.upload_window_frames, 3U);
  EXPECT_EQ(running.drain_timeout, std::chrono::seconds(7));
  EXPECT_EQ(running.limits.max_message_bytes, LimitOptions().max_message_bytes);
  EXPECT_EQ(running.log.format, LogFormat::kText);
  EXPECT_EQ(running.listen, ServerConfig().listen);
}

}  // namespace
}  // namespace steadymap
