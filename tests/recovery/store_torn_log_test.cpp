// What survives a kill and a power cut: everything that was synced, and nothing by halves.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.h"
#include "server/store.h"
#include "tests/server/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kPageBytes = 4096;
constexpr std::uint64_t kSectorBytes = 512;

/// Where the write-ahead log of `folder` is being written.
std::filesystem::path NewestLog(const std::filesystem::path& folder) {
  std::filesystem::path newest;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "rocksdb")) {
    if (entry.path().extension() == ".log") newest = std::max(newest, entry.path());
  }
  return newest;
}

/// A store that was left in the middle of its work, with the length of its write-ahead log after
/// each append. Tests open damaged copies of it.
class TornLog : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = folder_.path() / "original";
    std::unique_ptr<Store> store = Store::Open(folder, StoreOptions()).value();
    map_ = store->CreateMap(MakeMapRecord("acme", "hall")).value();
    map_end_ = std::filesystem::file_size(NewestLog(folder));
    std::mt19937 random(5);
    for (std::uint64_t i = 1; i <= 30; ++i) {
      LogAppend append{map_.key, Timestamp::FromSeconds(1000.0), {}, {MakeSession("s", i)}};
      append.frames.push_back(MakeLogFrame(i, i == 30 ? 200'000 : random() % 20'000));
      ASSERT_TRUE(store->AppendFrames({append}).ok());
      append_ends_.push_back(std::filesystem::file_size(NewestLog(folder)));
      sizes_.push_back(append.frames.front().packed_frame.size());
    }
    log_bytes_ = [&] {
      std::ifstream stream(NewestLog(folder), std::ios::binary);
      return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    }();
    // As a crash leaves it: copied while the store is open.
    std::filesystem::copy(
        folder, folder_.path() / "crashed", std::filesystem::copy_options::recursive);
  }

  /// Opens a copy of the crashed store whose log holds `bytes`.
  absl::StatusOr<std::unique_ptr<Store>> OpenWithLog(const std::string& bytes) {
    const std::filesystem::path copy = folder_.path() / "copy";
    std::filesystem::remove_all(copy);
    std::filesystem::copy(
        folder_.path() / "crashed", copy, std::filesystem::copy_options::recursive);
    std::ofstream(NewestLog(copy), std::ios::binary | std::ios::trunc) << bytes;
    return Store::Open(copy, StoreOptions());
  }

  /// Expects exactly the first `count` appends, whole.
  void ExpectAppends(Store* store, std::uint64_t count) {
    const std::vector<LogFrame> frames = ReadAll(store, map_.key);
    ASSERT_EQ(frames.size(), count);
    for (std::uint64_t i = 0; i < count; ++i) {
      EXPECT_TRUE(SameFrame(frames[i], MakeLogFrame(i + 1, sizes_[i]))) << i;
    }
    const StoredState state = store->LoadMap(map_).value();
    EXPECT_EQ(state.durable_head.value(), count);
    EXPECT_EQ(count == 0 ? 0 : state.sessions.front().settled.contiguous_end().value(), count);
  }

  std::uint64_t AppendsWithin(std::uint64_t bytes) const {
    return static_cast<std::uint64_t>(
        std::upper_bound(append_ends_.begin(), append_ends_.end(), bytes) - append_ends_.begin());
  }

  TemporaryFolder folder_;
  MapRecord map_;
  std::uint64_t map_end_ = 0;
  std::vector<std::uint64_t> append_ends_;  ///< Length of the log when the append returned.
  std::vector<std::size_t> sizes_;
  std::string log_bytes_;
};

TEST_F(TornLog, TruncatedAnywhereKeepsWhatWasSyncedBefore) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 25; ++i) {
    const std::uint64_t length = map_end_ + random() % (log_bytes_.size() - map_end_ + 1);
    absl::StatusOr<std::unique_ptr<Store>> store = OpenWithLog(log_bytes_.substr(0, length));
    ASSERT_TRUE(store.ok()) << store.status() << " at " << length;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(store->get(), AppendsWithin(length))) << length;
  }
}

TEST_F(TornLog, TailOfLostSectorsKeepsWhatWasSyncedBefore) {
  // What a power cut leaves of a write that had got its blocks but not its bytes.
  const std::uint64_t last_start = append_ends_[append_ends_.size() - 2];
  for (const std::uint64_t sectors : {0U, 1U, 7U, 8U, 100U, 300U}) {
    const std::uint64_t length =
        std::max(last_start, (last_start / kSectorBytes + sectors) * kSectorBytes);
    std::string bytes = log_bytes_.substr(0, length);
    bytes.resize(log_bytes_.size(), '\0');
    absl::StatusOr<std::unique_ptr<Store>> store = OpenWithLog(bytes);
    ASSERT_TRUE(store.ok()) << store.status() << " at " << length;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(store->get(), append_ends_.size() - 1)) << length;
  }
}

TEST_F(TornLog, PagesLostFromTheLastWriteDropThatWriteOnly) {
  const std::uint64_t last_start = append_ends_[append_ends_.size() - 2];
  std::mt19937_64 random(8);
  for (int i = 0; i < 15; ++i) {
    std::string bytes = log_bytes_;
    const std::uint64_t page =
        (last_start + random() % (bytes.size() - last_start)) / kPageBytes * kPageBytes;
    const std::uint64_t first = std::max(page, last_start);
    const std::uint64_t last = std::min<std::uint64_t>(page + kPageBytes, bytes.size());
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(first),
              bytes.begin() + static_cast<std::ptrdiff_t>(last),
              '\0');
    absl::StatusOr<std::unique_ptr<Store>> store = OpenWithLog(bytes);
    ASSERT_TRUE(store.ok()) << store.status() << " at " << first;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(store->get(), append_ends_.size() - 1)) << first;
  }
}

TEST_F(TornLog, FlippedBitIsDataLossNeverASilentlyShorterLog) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 40; ++i) {
    std::string bytes = log_bytes_;
    const std::uint64_t place = random() % bytes.size();
    bytes[place] = static_cast<char>(bytes[place] ^ (1 << (random() % 8)));
    const absl::Status status = OpenWithLog(bytes).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status << " at " << place;
    EXPECT_EQ(ReasonOf(status), reason::kChecksum);
  }
}

/// What a killed writer had reported.
struct Reported {
  std::uint64_t durable = 0;
  std::uint64_t revision = 0;
};

/// Runs the writer and kills it after it reported `lines` lines.
Reported KillWriterAfter(const std::filesystem::path& folder, int lines) {
  int ends[2] = {-1, -1};
  if (::pipe(ends) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
    ::close(ends[1]);
    ::execl(STEADYMAP_STORE_WRITER, "store_writer", folder.c_str(), nullptr);
    ::_exit(EXIT_FAILURE);
  }
  ::close(ends[1]);
  std::FILE* const output = ::fdopen(ends[0], "r");
  Reported reported;
  char kind[16] = {};
  unsigned long number = 0;
  for (int line = 0; std::fscanf(output, "%15s %lu", kind, &number) == 2; ++line) {
    (std::string(kind) == "durable" ? reported.durable : reported.revision) = number;
    if (line == lines) ::kill(child, SIGKILL);
  }
  std::fclose(output);
  ::waitpid(child, nullptr, 0);
  return reported;
}

TEST(StoreKill, NothingThatWasReportedDurableIsLost) {
  const TemporaryFolder folder;
  std::mt19937 random(10);
  std::uint64_t durable_before = 0;
  for (int round = 0; round < 10; ++round) {
    const Reported reported = KillWriterAfter(folder.path(), static_cast<int>(random() % 40));
    ASSERT_GT(reported.durable, durable_before) << "the writer must get on after a kill";
    const std::unique_ptr<Store> store = Store::Open(folder.path(), StoreOptions()).value();
    const MapRecord map = store->ListMaps()->front();
    const StoredState state = store->LoadMap(map).value();
    EXPECT_GE(state.durable_head.value(), reported.durable);
    EXPECT_GE(state.snapshot.revision.value(), reported.revision);
    const std::vector<LogFrame> frames = ReadAll(store.get(), map.key);
    ASSERT_EQ(frames.size(), state.durable_head.value());
    for (const LogFrame& frame : frames) {
      ASSERT_TRUE(SameFrame(frame, MakeLogFrame(frame.sequence.value())));
    }
    if (state.snapshot.revision.value() > 0) {
      const auto seed = static_cast<std::uint32_t>(state.snapshot.revision.value());
      EXPECT_EQ(LeavesOf(state.snapshot), std::vector<LeafChange>{MakeLeaf(0, 0, 0, seed)});
    }
    durable_before = state.durable_head.value();
  }
}

}  // namespace
}  // namespace steadymap
