// Tests steps of the machine's clock: no step makes a frame count twice. The program has its own
// wall clock, which the test sets.

#include <atomic>
#include <cstdint>
#include <ctime>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/temporary_folder.h"

namespace {

std::atomic<std::int64_t> wall_clock_step_s = 0;

}  // namespace

// Replaces the function of the C library in the whole program.
extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const int result = static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
  if (clock == CLOCK_REALTIME) time->tv_sec += wall_clock_step_s;
  return result;
}

namespace steadymap {
namespace {

constexpr std::int64_t kDayS = 24 * std::int64_t{3600};

class ClockStep : public ::testing::Test {
 protected:
  std::unique_ptr<TestService> Start() {
    return std::make_unique<TestService>(Transport::kInProcess,
                                         Store::Open(folder_.path(), StoreOptions()).value());
  }

  /// Runs the periodic trim of the maintenance with the daemon's default settings.
  void Trim() {
    const std::unique_ptr<Store> store = Store::Open(folder_.path(), StoreOptions()).value();
    const MapRecord map = store->ListMaps()->front();
    const StoredState state = store->LoadMap(map).value();
    TrimBounds bounds;
    bounds.uptime = state.uptime;
    bounds.forget_sessions_before = state.uptime - RetentionOptions().session_idle;
    const absl::Status status = store->Trim(map, bounds);
    ASSERT_TRUE(status.ok()) << status;
  }

  TemporaryFolder folder_;
};

TEST_F(ClockStep, ForwardAndBackNoSessionIsForgotten) {
  std::string map;
  const std::int64_t before_s = std::time(nullptr);
  for (const std::int64_t step_s : {std::int64_t{0}, 15 * kDayS, std::int64_t{0}, -400 * kDayS}) {
    SCOPED_TRACE(step_s);
    wall_clock_step_s = step_s;
    const std::unique_ptr<TestService> service = Start();
    if (map.empty()) map = service->CreateMap("hall");
    const absl::Status status = UploadAndClose(service.get(), {map}, MakeBatch(1, 10));
    EXPECT_TRUE(status.ok()) << status;
    EXPECT_EQ(service->GetMap(map)->state().durable_map_seq(), 10U) << "frames counted twice";
    service->server().Shutdown(std::chrono::seconds(10));
  }
  wall_clock_step_s = 15 * kDayS;
  timespec now{};
  ASSERT_EQ(::clock_gettime(CLOCK_REALTIME, &now), 0);
  EXPECT_GE(now.tv_sec, before_s + 14 * kDayS) << "the test's clock is not used";
  Trim();
  const std::unique_ptr<TestService> service = Start();
  UploadClient resumed(service.get());
  EXPECT_EQ(resumed.Open({map})->resume_client_seq(), 10U);
}

}  // namespace
}  // namespace steadymap
