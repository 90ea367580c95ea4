#include "server/process/memory_guard.h"

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

constexpr std::size_t kMegabyte = std::size_t{1} << 20;

TEST(MemoryGuard, RefusesWhileMoreIsHeldThanAllowedAndSaysHowMuch) {
  std::size_t held = 100 * kMegabyte;
  MemoryGuard guard(100 * kMegabyte, [&held] { return held; });
  EXPECT_TRUE(guard.Check().ok());
  guard.SetMax(held - 1);
  const absl::Status refused = guard.Check();
  EXPECT_EQ(refused.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(ReasonOf(refused), "MEMORY_LOW");
  EXPECT_NE(refused.message().find("104857600"), std::string::npos) << refused;
  EXPECT_NE(refused.message().find("104857599"), std::string::npos) << refused;
  EXPECT_GT(RetryDelayMsOf(refused), 0);
  guard.SetMax(held);
  EXPECT_TRUE(guard.Check().ok());
}

TEST(MemoryGuard, MeasuresSeldomHoweverOftenItIsAsked) {
  int measured = 0;
  const MemoryGuard guard(1, [&measured] { return static_cast<std::size_t>(++measured); });
  const auto start = MemoryGuard::Clock::now();
  for (int i = 0; i < 1000; ++i) guard.Check().IgnoreError();
  const auto took = MemoryGuard::Clock::now() - start;
  EXPECT_GE(measured, 1);
  EXPECT_LE(measured, 1 + took / std::chrono::milliseconds(100));
}

TEST(ResidentBytes, GrowsWithWhatIsWritten) {
  const std::size_t before = ResidentBytes();
  EXPECT_GT(before, kMegabyte);
  const std::vector<char> block(64 * kMegabyte, 'x');
  EXPECT_GT(ResidentBytes(), before + 48 * kMegabyte) << block.size();
}

/// A machine, as described by files in /proc and /sys.
class Machine : public ::testing::Test {
 protected:
  void Write(const std::string& file, const std::string& text) {
    const std::filesystem::path path = folder_.path() / file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }

  std::size_t Usable() const { return UsableMemoryBytes(folder_.path()); }

  TemporaryFolder folder_;
};

TEST_F(Machine, MemoryIsThatOfTheMachineWithoutALimit) {
  Write("proc/meminfo", "MemFree:  5 kB\nMemTotal:       16384 kB\nMemAvailable: 7 kB\n");
  EXPECT_EQ(Usable(), 16 * kMegabyte);
  Write("proc/self/cgroup", "0::/system.slice/steadymapd.service\n");
  Write("sys/fs/cgroup/system.slice/memory.max", "max\n");
  EXPECT_EQ(Usable(), 16 * kMegabyte);
}

TEST_F(Machine, MemoryIsTheLeastLimitOfTheControlGroupsAround) {
  Write("proc/meminfo", "MemTotal: 16384 kB\n");
  Write("proc/self/cgroup", "1:name=systemd:/x\n0::/system.slice/steadymapd.service\n");
  Write("sys/fs/cgroup/system.slice/steadymapd.service/memory.max", "8388608\n");
  EXPECT_EQ(Usable(), 8 * kMegabyte);
  Write("sys/fs/cgroup/system.slice/memory.max", "4194304\n");
  EXPECT_EQ(Usable(), 4 * kMegabyte);
  Write("sys/fs/cgroup/memory.max", "2097152\n");
  EXPECT_EQ(Usable(), 2 * kMegabyte) << "the limit of the container";
}

TEST(UsableMemoryBytes, OfThisMachineHoldsThisProcess) {
  EXPECT_GT(UsableMemoryBytes(), ResidentBytes());
  EXPECT_EQ(MemoryGuard(0).max_bytes(), UsableMemoryBytes() / 4 * 3);
}

}  // namespace
}  // namespace steadymap
