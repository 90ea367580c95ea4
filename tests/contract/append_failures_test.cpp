// Tests random failures of appends with a store on disk: every frame acknowledged as durable is in
// the map exactly once. STEADYMAP_FAULT_SEEDS and STEADYMAP_FAULT_FRAMES make the test longer.

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include <absl/synchronization/mutex.h>
#include <gtest/gtest.h>

#include "server/store/disk/posix_file.h"
#include "tests/contract/test_service.h"
#include "tests/contract/upload_client.h"
#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Eventually;

std::uint64_t FromEnvironment(const char* name, std::uint64_t otherwise) {
  const char* const text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread.
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Makes calls on log files fail at random: mostly for lack of space, sometimes permanently.
class RandomFaults {
 public:
  RandomFaults(std::uint64_t seed, double probability)
      : random_(seed), fails_(probability), is_broken_(0.1) {
    SetFileFaultsForTest([this](FileCall /*call*/, const std::filesystem::path& file) {
      if (file.extension() != ".log") return 0;
      const absl::MutexLock lock(&mutex_);
      if (!fails_(random_)) return 0;
      ++failures_;
      return is_broken_(random_) ? EIO : ENOSPC;
    });
  }

  ~RandomFaults() { SetFileFaultsForTest({}); }

  RandomFaults(const RandomFaults&) = delete;
  RandomFaults& operator=(const RandomFaults&) = delete;

  int failures() const {
    const absl::MutexLock lock(&mutex_);
    return failures_;
  }

 private:
  mutable absl::Mutex mutex_;
  std::mt19937_64 random_;
  std::bernoulli_distribution fails_;
  std::bernoulli_distribution is_broken_;
  int failures_ = 0;
};

class AppendFailures : public ::testing::Test {
 protected:
  /// Sends all frames after the resume point without waiting; returns the last acknowledged frame,
  /// from an acknowledgement or a stream's resume point.
  static std::uint64_t SendWithoutWaiting(TestService* service,
                                          const std::string& map,
                                          std::uint64_t last_frame) {
    UploadClient client(service);
    const absl::StatusOr<v1::UploadOpened> opened = client.Open({map}, {v1::ACK_LEVEL_DURABLE});
    if (!opened.ok()) return 0;
    constexpr int kBatch = 3;
    std::uint64_t next = opened->resume_client_seq() + 1;
    const std::uint64_t end =
        std::min(last_frame, opened->resume_client_seq() + opened->credit().frames());
    while (next <= end) {
      const int count = std::min(kBatch, static_cast<int>(end - next + 1));
      if (!client.Send(MakeBatch(next, count))) break;
      next += static_cast<std::uint64_t>(count);
    }
    client.Close().IgnoreError();
    return std::max(opened->resume_client_seq(), client.newest(v1::ACK_LEVEL_DURABLE).client_seq());
  }

  /// `MakeBatch` gives frame n the time 100 + n; the log must contain them in this order.
  static std::uint64_t CountLogged(Store* store) {
    const MapRecord map = store->ListMaps()->front();
    EXPECT_TRUE(store->LoadMap(map).ok());
    std::uint64_t frames = 0;
    const absl::Status status =
        store->ReadLog(map.key, MapSequence(1), [&frames](const LogEntry& entry) {
          v1::Frame frame;
          EXPECT_TRUE(frame.ParseFromString(entry.packed_frame));
          EXPECT_EQ(frame.capture_time().seconds() - 100, static_cast<std::int64_t>(++frames));
          return absl::OkStatus();
        });
    EXPECT_TRUE(status.ok()) << status;
    return frames;
  }
};

TEST_F(AppendFailures, EveryAcknowledgedFrameIsInTheMapOnce) {
  const std::uint64_t seeds = FromEnvironment("STEADYMAP_FAULT_SEEDS", 2);
  const std::uint64_t frames = FromEnvironment("STEADYMAP_FAULT_FRAMES", 300);
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE(seed);
    const TemporaryFolder folder;
    {
      TestService service(
          Transport::kLoopback,
          Store::Open(folder.path(), StoreOptions()).value(),
          [](ServerConfig* config) { config->commit.max_delay = std::chrono::milliseconds(20); });
      const std::string map = service.CreateMap("hall");
      const RandomFaults faults(seed, 0.01 + 0.19 * static_cast<double>(seed % 8) / 7.0);
      std::uint64_t acknowledged = 0;
      EXPECT_TRUE(Eventually([&] {
        const std::uint64_t before = acknowledged;
        acknowledged = std::max(acknowledged, SendWithoutWaiting(&service, map, frames));
        // A failure may revert only unacknowledged frames.
        EXPECT_GE(service.GetMap(map)->state().durable_map_seq(), before);
        return acknowledged >= frames;
      }));
      EXPECT_GT(faults.failures(), 0);
    }
    const std::unique_ptr<Store> store = Store::Open(folder.path(), StoreOptions()).value();
    EXPECT_EQ(CountLogged(store.get()), frames);
  }
}

}  // namespace
}  // namespace steadymap
