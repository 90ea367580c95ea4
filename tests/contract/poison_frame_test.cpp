// Tests a log entry that crashes the server in every integration: only its map stops, at the
// revision before it, until an operator skips the entry.

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>

#include "server/store/repair/map_salvage.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Eventually;
using ::testing::HasSubstr;

class PoisonFrame : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kPoison = 4;

  /// Creates a store with two maps; the log of `hall` holds entries 1 to 6, none of them
  /// integrated.
  void SetUp() override {
    {
      TestService service(Transport::kInProcess, OpenStore());
      service.CreateMap("hall");
      service.CreateMap("yard");
    }
    const std::unique_ptr<Store> store = OpenStore();
    const MapRecord hall = store->ListMaps()->front();
    ASSERT_EQ(hall.name.map, "hall");
    ASSERT_TRUE(store->LoadMap(hall).ok());
    LogAppend append{hall.key, MapUptime(1), {}, {}};
    const v1::FrameBatch batch = MakeBatch(1, 6);
    for (int i = 0; i < batch.frames_size(); ++i) {
      append.entries.push_back({MapSequence(static_cast<std::uint64_t>(i) + 1),
                                LogEntryKind::kFrame,
                                {"robot-1", "camera"},
                                batch.frames(i).SerializeAsString()});
    }
    ASSERT_TRUE(store->Append(append).ok());
  }

  std::unique_ptr<Store> OpenStore() {
    return Store::Open(folder_.path() / "data", StoreOptions()).value();
  }

  /// Runs a process that ends with `signal` while it integrates an entry of the hall.
  void EndOn(std::uint64_t sequence, int signal) {
    std::vector<std::string> arguments = {STEADYMAP_ENTRY_CRASHER,
                                          (folder_.path() / "data").string(),
                                          "hall",
                                          std::to_string(sequence),
                                          std::to_string(signal)};
    std::vector<char*> pointers;
    pointers.reserve(arguments.size() + 1);
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    pid_t child = -1;
    ASSERT_EQ(::posix_spawn(&child, pointers.front(), nullptr, nullptr, pointers.data(), environ),
              0);
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status)) << status;
    ASSERT_EQ(WTERMSIG(status), signal);
  }

  /// Starts a server and waits until the hall's log is integrated or the map has stopped.
  v1::MapState StateOfHall() {
    TestService service(Transport::kInProcess, OpenStore(), CommitAtOnce);
    return SettledState(&service);
  }

  static void CommitAtOnce(ServerConfig* config) {
    config->commit.max_delay = std::chrono::milliseconds(1);
  }

  static v1::MapState SettledState(TestService* service) {
    v1::MapState state;
    EXPECT_TRUE(Eventually([&] {
      const absl::StatusOr<v1::Map> map = service->GetMap("tenants/test/maps/hall");
      if (map.ok()) state = map->state();
      return state.revision() == 6 || state.condition() == v1::MAP_CONDITION_QUARANTINED;
    }));
    return state;
  }

  TemporaryFolder folder_;
};

TEST_F(PoisonFrame, TwoCrashesQuarantineTheMapAloneAtTheRevisionBefore) {
  for (int i = 0; i < 2; ++i) EndOn(kPoison, SIGABRT);
  TestService service(Transport::kInProcess, OpenStore(), CommitAtOnce);
  const v1::MapState state = SettledState(&service);
  EXPECT_EQ(state.condition(), v1::MAP_CONDITION_QUARANTINED);
  EXPECT_THAT(state.condition_reason(), HasSubstr("--skip-entry 4"));
  EXPECT_EQ(state.revision(), kPoison - 1);
  EXPECT_TRUE(service.Export("tenants/test/maps/hall", v1::EXPORT_FORMAT_PLY).ok());
  EXPECT_EQ(ReasonOf(UploadAndClose(&service, {"tenants/test/maps/hall"}, MakeBatch(7, 1))),
            "MAP_QUARANTINED");
  EXPECT_TRUE(UploadAndClose(&service, {"tenants/test/maps/yard"}, MakeBatch(1, 2)).ok());
}

TEST_F(PoisonFrame, OneCrashOrAnyNumberOfQuickKillsIsNoReason) {
  EndOn(kPoison, SIGABRT);
  for (int i = 0; i < 4; ++i) EndOn(kPoison, SIGKILL);
  const v1::MapState state = StateOfHall();
  EXPECT_EQ(state.condition(), v1::MAP_CONDITION_READY);
  EXPECT_EQ(state.revision(), 6U);
}

TEST_F(PoisonFrame, QuarantineHoldsAcrossRestartsUntilTheEntryIsPassedOver) {
  for (int i = 0; i < 2; ++i) EndOn(kPoison, SIGSEGV);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(StateOfHall().condition(), v1::MAP_CONDITION_QUARANTINED);
  }
  const absl::StatusOr<SalvageReport> report =
      SalvageMap({folder_.path() / "data", {"test", "hall"}, MapSequence(kPoison)});
  ASSERT_TRUE(report.ok()) << report.status();
  const v1::MapState state = StateOfHall();
  EXPECT_EQ(state.condition(), v1::MAP_CONDITION_READY);
  EXPECT_EQ(state.revision(), 6U);
  const std::unique_ptr<Store> store = OpenStore();
  const MapRecord hall = store->ListMaps()->front();
  ASSERT_TRUE(store->LoadMap(hall).ok());
  EXPECT_EQ(store->ReadPoses(hall.key, MapSequence(1), MapSequence(6), 10)->size(), 5U);
}

}  // namespace
}  // namespace steadymap
