// Tests the state after a kill or a power cut: all synced data survives, and no partial writes.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/types/error.h"
#include "server/store/model/store.h"
#include "server/store/repair/store_check.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kPageBytes = 4096;
constexpr std::uint64_t kSectorBytes = 512;

/// Returns the newest file with the extension `.log` in the folders called `name` below `folder`.
std::filesystem::path NewestLog(const std::filesystem::path& folder, const std::string& name) {
  std::filesystem::path newest;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::filesystem::path& file = entry.path();
    if (file.extension() != ".log" || file.parent_path().filename() != name) continue;
    newest = std::max(newest, file);
  }
  return newest;
}

/// A store that was interrupted during its work. Tests open copies of it with one damaged file: the
/// newest of a map's log, or of its database's write-ahead log.
class TornLog : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = folder_.path() / "original";
    std::unique_ptr<Store> store = Store::Open(folder, StoreOptions()).value();
    map_ = store->CreateMap(MakeMapRecord("acme", "hall")).value();
    ASSERT_TRUE(store->LoadMap(map_).ok());
    std::mt19937 random(5);
    for (std::uint64_t i = 1; i <= 30; ++i) {
      LogAppend append{map_.key, kStoreTime, {}, {MakeSession("s", 2 * i)}};
      append.entries.push_back(MakeLogEntry(2 * i - 1, i == 30 ? 200'000 : random() % 20'000));
      append.entries.push_back(MakeLogEntry(2 * i, 100));
      ASSERT_TRUE(store->Append(append).ok());
      append_ends_.push_back(std::filesystem::file_size(NewestLog(folder, "log")));
      sizes_.push_back(append.entries.front().packed_frame.size());
    }
    for (std::uint64_t i = 1; i <= 10; ++i) {
      const MapDelta delta = MakeDelta(i - 1, i, {MakeLeaf(static_cast<std::int32_t>(i), 0, 0, 1)});
      ASSERT_TRUE(store->CommitRevision(map_.key, delta, MakeDetails(delta)).ok());
      commit_ends_.push_back(std::filesystem::file_size(NewestLog(folder, "state")));
    }
    // State after a crash: copied while the store is open. The note, which a power cut may revert,
    // is removed.
    std::filesystem::copy(
        folder, folder_.path() / "crashed", std::filesystem::copy_options::recursive);
    std::filesystem::remove(
        NewestLog(folder_.path() / "crashed", "log").parent_path().parent_path() / "note");
    log_bytes_ = ContentOf(NewestLog(folder, "log"));
    wal_bytes_ = ContentOf(NewestLog(folder, "state"));
  }

  /// Opens the map in a copy of the crashed store with `bytes` as the newest log in the folder
  /// `name`.
  absl::StatusOr<StoredState> LoadWith(const std::string& name, const std::string& bytes) {
    const std::filesystem::path copy = folder_.path() / "copy";
    store_.reset();
    std::filesystem::remove_all(copy);
    std::filesystem::copy(
        folder_.path() / "crashed", copy, std::filesystem::copy_options::recursive);
    std::ofstream(NewestLog(copy, name), std::ios::binary | std::ios::trunc) << bytes;
    store_ = Store::Open(copy, StoreOptions()).value();
    return store_->LoadMap(map_);
  }

  /// Expects exactly the first `count` appends, complete. The database records ten entries, so
  /// missing entries among the first five appends are always detected.
  void ExpectAppends(const StoredState& state, std::uint64_t count) {
    const std::vector<LogEntry> entries = ReadAll(store_.get(), map_.key);
    ASSERT_EQ(entries.size(), 2 * count);
    for (std::uint64_t i = 0; i < count; ++i) {
      EXPECT_TRUE(SameEntry(entries[2 * i], MakeLogEntry(2 * i + 1, sizes_[i]))) << i;
    }
    EXPECT_EQ(state.durable_head.value(), 2 * count);
    EXPECT_EQ(state.sessions.front().settled.contiguous_end().value(), 2 * count);
  }

  static std::uint64_t CountWithin(const std::vector<std::uint64_t>& ends, std::uint64_t bytes) {
    return static_cast<std::uint64_t>(std::upper_bound(ends.begin(), ends.end(), bytes) -
                                      ends.begin());
  }

  TemporaryFolder folder_;
  MapRecord map_;
  std::vector<std::uint64_t> append_ends_;  ///< Length of the log after each append.
  std::vector<std::uint64_t> commit_ends_;  ///< Length of the write-ahead log after each commit.
  std::vector<std::size_t> sizes_;
  std::string log_bytes_;
  std::string wal_bytes_;
  std::unique_ptr<Store> store_;
};

TEST_F(TornLog, TruncatedAnywhereKeepsWhatWasSyncedBefore) {
  std::mt19937_64 random(6);
  // The commits recorded all appends in the database, so a missing recorded entry is lost, not
  // torn.
  for (int i = 0; i < 10; ++i) {
    const std::uint64_t length = random() % append_ends_.back();
    const absl::StatusOr<StoredState> state = LoadWith("log", log_bytes_.substr(0, length));
    EXPECT_EQ(ReasonOf(state.status()), reason::kChecksum) << state.status() << " at " << length;
  }
  // Without the commits, a crash may leave any length.
  std::filesystem::resize_file(NewestLog(folder_.path() / "crashed", "state"), commit_ends_[0] / 2);
  for (int i = 0; i < 25; ++i) {
    const std::uint64_t length = random() % (log_bytes_.size() + 1);
    const absl::StatusOr<StoredState> state = LoadWith("log", log_bytes_.substr(0, length));
    if (length < append_ends_[0]) continue;
    ASSERT_TRUE(state.ok()) << state.status() << " at " << length;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(*state, CountWithin(append_ends_, length))) << length;
    EXPECT_TRUE(store_->Append(MakeAppend(map_.key, state->durable_head.value() + 1, 1)).ok());
  }
}

/// State before the first commit: the database has no record of the log.
class TornLogWithoutCommits : public TornLog {
 protected:
  void SetUp() override {
    TornLog::SetUp();
    std::filesystem::resize_file(NewestLog(folder_.path() / "crashed", "state"),
                                 commit_ends_[0] / 2);
  }
};

TEST_F(TornLogWithoutCommits, TailOfLostSectorsKeepsWhatWasSyncedBefore) {
  // The state after a power cut of a write with allocated blocks but without its bytes.
  const std::uint64_t last_start = append_ends_[append_ends_.size() - 2];
  for (const std::uint64_t sectors : {0U, 1U, 7U, 8U, 100U, 300U}) {
    const std::uint64_t length =
        std::max(last_start, (last_start / kSectorBytes + sectors) * kSectorBytes);
    std::string bytes = log_bytes_.substr(0, length);
    bytes.resize(log_bytes_.size(), '\0');
    const absl::StatusOr<StoredState> state = LoadWith("log", bytes);
    ASSERT_TRUE(state.ok()) << state.status() << " at " << length;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(*state, append_ends_.size() - 1)) << length;
  }
}

TEST_F(TornLogWithoutCommits, PagesLostFromTheLastWriteDropThatWriteOnly) {
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
    const absl::StatusOr<StoredState> state = LoadWith("log", bytes);
    ASSERT_TRUE(state.ok()) << state.status() << " at " << first;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(*state, append_ends_.size() - 1)) << first;
  }
}

TEST_F(TornLogWithoutCommits, PagesLostFromAnEarlierWriteAreDamage) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 15; ++i) {
    std::string bytes = log_bytes_;
    const std::uint64_t place = random() % (append_ends_[20] - kSectorBytes);
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(place), kSectorBytes, '\0');
    if (bytes == log_bytes_) continue;
    const absl::Status status = LoadWith("log", bytes).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status << " at " << place;
  }
}

TEST_F(TornLogWithoutCommits, FlippedBitIsDataLossNeverASilentlyShorterLog) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 40; ++i) {
    std::string bytes = log_bytes_;
    const std::uint64_t place = random() % bytes.size();
    bytes[place] = static_cast<char>(bytes[place] ^ (1 << (random() % 8)));
    const absl::StatusOr<StoredState> state = LoadWith("log", bytes);
    // Zeros that complete a record carry no information.
    if (state.ok()) {
      ASSERT_NO_FATAL_FAILURE(ExpectAppends(*state, append_ends_.size())) << place;
      continue;
    }
    EXPECT_EQ(state.status().code(), absl::StatusCode::kDataLoss) << " at " << place;
    EXPECT_EQ(ReasonOf(state.status()), reason::kChecksum);
  }
}

TEST_F(TornLog, TruncatedWriteAheadLogKeepsTheCommitsThatWereSyncedBefore) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 25; ++i) {
    const std::uint64_t length =
        commit_ends_[0] + random() % (wal_bytes_.size() - commit_ends_[0] + 1);
    const absl::StatusOr<StoredState> state = LoadWith("state", wal_bytes_.substr(0, length));
    ASSERT_TRUE(state.ok()) << state.status() << " at " << length;
    const std::uint64_t commits = CountWithin(commit_ends_, length);
    EXPECT_EQ(state->snapshot.revision.value(), commits) << length;
    EXPECT_EQ(LeavesOf(state->snapshot).size(), commits) << length;
    ASSERT_NO_FATAL_FAILURE(ExpectAppends(*state, append_ends_.size())) << length;
  }
}

TEST_F(TornLog, ACheckOverlooksWhatAPowerCutLeftOfTheLastCommitAndChangesNothing) {
  const std::uint64_t last_start = commit_ends_[commit_ends_.size() - 2];
  // The last write has its full length, but not all of its sectors.
  std::string bytes = wal_bytes_;
  bytes.resize(bytes.size() + 4 * kSectorBytes, '\0');
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(last_start) + 20, bytes.end(), '\0');
  const std::filesystem::path crashed = folder_.path() / "crashed";
  const std::filesystem::path log = NewestLog(crashed, "state");
  std::ofstream(log, std::ios::binary | std::ios::trunc) << bytes;
  const absl::Status status = CheckDatabase(log.parent_path());
  EXPECT_TRUE(status.ok()) << status;
  const absl::StatusOr<StoreCheckResult> findings = CheckStore(crashed, std::nullopt);
  ASSERT_TRUE(findings.ok()) << findings.status();
  ASSERT_EQ(findings->maps.size(), 1U);
  EXPECT_THAT(findings->maps.front().problems, ::testing::IsEmpty());
  EXPECT_EQ(ContentOf(log), bytes);
  // A server loads the same map.
  const absl::StatusOr<StoredState> state = LoadWith("state", bytes);
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->snapshot.revision.value(), commit_ends_.size() - 1);
}

TEST_F(TornLog, ACheckFindsDamageBeforeWhatAPowerCutLeft) {
  std::string bytes = wal_bytes_;
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(commit_ends_[commit_ends_.size() - 2]) + 20,
            bytes.end(),
            '\0');
  bytes[commit_ends_[3] + 30] = static_cast<char>(bytes[commit_ends_[3] + 30] ^ 1);
  const std::filesystem::path log = NewestLog(folder_.path() / "crashed", "state");
  std::ofstream(log, std::ios::binary | std::ios::trunc) << bytes;
  EXPECT_EQ(CheckDatabase(log.parent_path()).code(), absl::StatusCode::kDataLoss);
}

TEST_F(TornLog, FlippedBitInTheWriteAheadLogIsDataLossNeverAnOlderMap) {
  std::mt19937_64 random(10);
  for (int i = 0; i < 40; ++i) {
    std::string bytes = wal_bytes_;
    const std::uint64_t place = random() % bytes.size();
    bytes[place] = static_cast<char>(bytes[place] ^ (1 << (random() % 8)));
    const absl::Status status = LoadWith("state", bytes).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status << " at " << place;
    EXPECT_EQ(ReasonOf(status), reason::kChecksum);
  }
}

/// Last reports of a killed writer.
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
    ASSERT_GT(reported.durable, durable_before) << "no progress after a kill";
    const std::unique_ptr<Store> store = Store::Open(folder.path(), StoreOptions()).value();
    const MapRecord map = store->ListMaps()->front();
    const StoredState state = store->LoadMap(map).value();
    EXPECT_GE(state.durable_head.value(), reported.durable);
    EXPECT_GE(state.snapshot.revision.value(), reported.revision);
    const std::vector<LogEntry> entries = ReadAll(store.get(), map.key);
    ASSERT_EQ(entries.size(), state.durable_head.value());
    for (const LogEntry& entry : entries) {
      ASSERT_TRUE(SameEntry(entry, MakeLogEntry(entry.sequence.value())));
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
