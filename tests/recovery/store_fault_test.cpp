// Tests a store with disk failures.

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>
#include <rocksdb/env.h>
#include <sys/stat.h>

#include "core/types/error.h"
#include "server/store/disk/posix_file.h"
#include "server/store/rocks_store.h"
#include "tests/recovery/faulty_file_system.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

class StoreFault : public ::testing::Test {
 protected:
  void SetUp() override {
    Open(StoreOptions());
    map_ = Create("hall");
    other_ = Create("yard");
  }

  void TearDown() override { SetFileFaultsForTest({}); }

  void Open(const StoreOptions& options) {
    store_.reset();
    RocksStore::Platform platform;
    platform.file_system = faults_;
    platform.free_disk_bytes = [this](const std::filesystem::path&) { return free_bytes_.load(); };
    store_ = RocksStore::Open(folder_.path(), options, platform).value();
  }

  MapRecord Create(const std::string& name) {
    MapRecord map = store_->CreateMap(MakeMapRecord("acme", name)).value();
    EXPECT_TRUE(store_->LoadMap(map).ok());
    EXPECT_TRUE(store_->Append(MakeAppend(map.key, 1, 3)).ok());
    return map;
  }

  /// Makes one kind of call on the files of the log fail.
  void FailLog(FileCall call, int error) {
    SetFileFaultsForTest([=](FileCall made, const std::filesystem::path& file) {
      return made == call && file.extension() == ".log" ? error : 0;
    });
  }

  absl::Status Commit(const MapRecord& map, std::uint64_t from, std::uint64_t to) {
    const MapDelta delta = MakeDelta(from, to, {MakeLeaf(0, 0, 0, 1)});
    return store_->CommitRevision(map.key, delta, MakeDetails(delta)).status();
  }

  void ExpectReadOnly(const absl::Status& status) {
    EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
    EXPECT_EQ(ReasonOf(status), reason::kStoreReadOnly);
  }

  /// Expects that every write to the map is refused without another attempt, every read works,
  /// other maps are unaffected, and a reload of the map finds the acknowledged entries.
  void ExpectReadOnlyUntilLoaded() {
    const int syncs = faults_->syncs;
    ExpectReadOnly(store_->health(map_.key));
    ExpectReadOnly(store_->Append(MakeAppend(map_.key, 4, 1)));
    EXPECT_EQ(faults_->syncs, syncs) << "a failed sync must not be tried again";
    EXPECT_GE(ReadAll(store_.get(), map_.key).size(), 3U);
    EXPECT_TRUE(store_->health(other_.key).ok());
    EXPECT_TRUE(store_->Append(MakeAppend(other_.key, 4, 1)).ok());
    EXPECT_TRUE(Commit(other_, 0, 4).ok());
    const absl::StatusOr<StoredState> state = store_->LoadMap(map_);
    ASSERT_TRUE(state.ok()) << state.status();
    EXPECT_TRUE(store_->health(map_.key).ok());
    EXPECT_EQ(state->durable_head, MapSequence(3));
    EXPECT_EQ(state->sessions.front().settled.contiguous_end(), ClientSequence(3));
    EXPECT_TRUE(store_->Append(MakeAppend(map_.key, 4, 1)).ok());
    EXPECT_EQ(ReadAll(store_.get(), map_.key).size(), 4U);
  }

  TemporaryFolder folder_;
  std::shared_ptr<FaultyFileSystem> faults_ = std::make_shared<FaultyFileSystem>();
  std::atomic<std::uint64_t> free_bytes_ = std::uint64_t{1} << 40;
  std::unique_ptr<RocksStore> store_;
  MapRecord map_;
  MapRecord other_;
};

TEST_F(StoreFault, FailedSyncOfAnAppendStopsItsMapUntilItIsLoaded) {
  FailLog(FileCall::kSync, EIO);
  ExpectReadOnly(store_->Append(MakeAppend(map_.key, 4, 2)));
  SetFileFaultsForTest({});
  ExpectReadOnlyUntilLoaded();
}

TEST_F(StoreFault, FailedWriteOfAnAppendStopsItsMapUntilItIsLoaded) {
  FailLog(FileCall::kWrite, EIO);
  ExpectReadOnly(store_->Append(MakeAppend(map_.key, 4, 2)));
  SetFileFaultsForTest({});
  ExpectReadOnlyUntilLoaded();
}

TEST_F(StoreFault, FailedSyncOfACommitStopsItsMapUntilItIsLoaded) {
  faults_->fail_sync = true;
  ExpectReadOnly(Commit(map_, 0, 2));
  faults_->fail_sync = false;
  ExpectReadOnlyUntilLoaded();
  // The commit was not acknowledged: it may exist or not, but only completely.
  const std::uint64_t revision = store_->LoadMap(map_)->snapshot.revision.value();
  EXPECT_TRUE(revision == 0 || revision == 2) << revision;
  EXPECT_TRUE(Commit(map_, revision, 3).ok());
}

TEST_F(StoreFault, FullDiskRefusesAppendsAndNothingElse) {
  for (const FileCall call : {FileCall::kReserve, FileCall::kWrite, FileCall::kSync}) {
    FailLog(call, ENOSPC);
    const absl::Status status = store_->Append(MakeAppend(map_.key, 4, 2));
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(ReasonOf(status), reason::kDiskLow);
    EXPECT_TRUE(store_->health(map_.key).ok()) << "it heals by itself";
    EXPECT_EQ(ReadAll(store_.get(), map_.key).size(), 3U);
  }
  SetFileFaultsForTest({});
  EXPECT_TRUE(store_->Append(MakeAppend(map_.key, 4, 2)).ok());
  EXPECT_EQ(ReadAll(store_.get(), map_.key).size(), 5U);
}

TEST_F(StoreFault, LogTakesDiskSpaceAheadAndGivesItBackWhenItIsClosed) {
  const auto taken_bytes = [this] {
    std::uintmax_t size = 0;
    std::uintmax_t taken = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path())) {
      if (entry.path().extension() != ".log" || entry.path().parent_path().filename() != "log") {
        continue;
      }
      struct stat info {};

      EXPECT_EQ(::stat(entry.path().c_str(), &info), 0);
      size += entry.file_size();
      taken += 512 * static_cast<std::uintmax_t>(info.st_blocks);
    }
    return std::pair(size, taken);
  };
  LogAppend append = MakeAppend(map_.key, 4, 1);
  append.entries = {MakeLogEntry(4, 300'000)};
  ASSERT_TRUE(store_->Append(append).ok());
  append = MakeAppend(map_.key, 5, 1);
  append.entries = {MakeLogEntry(5, 5'000)};
  ASSERT_TRUE(store_->Append(append).ok());
  const auto [open_size, open_taken] = taken_bytes();
  EXPECT_GT(open_taken, open_size + 200'000) << "the next appends find their space";
  store_.reset();
  const auto [size, taken] = taken_bytes();
  EXPECT_EQ(size, open_size);
  EXPECT_LT(taken, size + 100'000);
}

TEST_F(StoreFault, CommitOnADiskThatFillsUpWaitsForRoom) {
  faults_->disk_full = true;
  std::atomic<bool> done = false;
  std::thread commit([&] {
    EXPECT_TRUE(Commit(map_, 0, 3).ok());
    done = true;
  });
  while (!store_->IsWaitingForDisk()) std::this_thread::yield();
  EXPECT_FALSE(done);
  EXPECT_TRUE(store_->LoadMap(map_).ok()) << "reads go on";
  EXPECT_EQ(ReadAll(store_.get(), map_.key).size(), 3U);
  faults_->disk_full = false;
  commit.join();
  EXPECT_EQ(store_->LoadMap(map_)->snapshot.revision, Revision(3));
}

TEST_F(StoreFault, StoreThatWaitsForRoomCanBeClosedAndLosesNothing) {
  faults_->disk_full = true;
  std::thread commit([&] { ExpectReadOnly(Commit(map_, 0, 3)); });
  while (!store_->IsWaitingForDisk()) std::this_thread::yield();
  store_->StopWaitingForDisk();
  commit.join();
  store_.reset();
  faults_->disk_full = false;
  Open(StoreOptions());
  ASSERT_TRUE(store_->LoadMap(map_).ok());
  EXPECT_EQ(ReadAll(store_.get(), map_.key).size(), 3U);
  EXPECT_TRUE(Commit(map_, 0, 3).ok());
}

TEST_F(StoreFault, LowDiskRefusesAppendsAndNewMapsFirstAndCommitsGoOn) {
  free_bytes_ = StoreOptions().min_free_disk_bytes - 1;
  for (const absl::Status& status : {store_->Append(MakeAppend(map_.key, 4, 1)),
                                     store_->CreateMap(MakeMapRecord("acme", "third")).status(),
                                     store_->CheckDisk()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(ReasonOf(status), reason::kDiskLow);
  }
  EXPECT_TRUE(store_->health(map_.key).ok());
  EXPECT_TRUE(Commit(map_, 0, 3).ok());
  free_bytes_ = StoreOptions().write_buffer_bytes - 1;
  EXPECT_EQ(ReasonOf(Commit(other_, 0, 3)), reason::kDiskLow) << "before RocksDB has no room";
  EXPECT_TRUE(store_->DeleteMap(map_.key).ok());
  free_bytes_ = std::uint64_t{1} << 40;
  EXPECT_TRUE(Commit(other_, 0, 3).ok());
  EXPECT_TRUE(store_->Append(MakeAppend(other_.key, 4, 1)).ok());
}

TEST_F(StoreFault, MapOpensForReadingAloneOnAFullDiskAndHealsWhenItIsLoaded) {
  ASSERT_TRUE(Commit(map_, 0, 2).ok());
  free_bytes_ = 0;
  faults_->disk_full = true;
  Open(StoreOptions());
  const absl::StatusOr<StoredState> state = store_->LoadMap(map_);
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(LeavesOf(state->snapshot).size(), 1U);
  EXPECT_EQ(state->durable_head, MapSequence(3));
  EXPECT_EQ(ReadAll(store_.get(), map_.key).size(), 3U);
  EXPECT_EQ(ReasonOf(store_->health(map_.key)), reason::kDiskLow);
  EXPECT_EQ(ReasonOf(store_->Append(MakeAppend(map_.key, 4, 1))), reason::kDiskLow);
  EXPECT_EQ(ReasonOf(Commit(map_, 2, 3)), reason::kDiskLow);
  free_bytes_ = std::uint64_t{1} << 40;
  faults_->disk_full = false;
  ASSERT_TRUE(store_->LoadMap(map_).ok());
  EXPECT_TRUE(store_->health(map_.key).ok());
  EXPECT_TRUE(store_->Append(MakeAppend(map_.key, 4, 1)).ok());
  EXPECT_TRUE(Commit(map_, 2, 4).ok());
}

TEST_F(StoreFault, DiskWithItsReserveFreeIsEnoughForAMapToBeWrittenTo) {
  StoreOptions options;
  options.write_buffer_bytes = std::size_t{1} << 20;
  options.min_free_disk_bytes = 3 * options.write_buffer_bytes;
  free_bytes_ = options.min_free_disk_bytes;
  Open(options);
  ASSERT_TRUE(store_->LoadMap(map_).ok());
  EXPECT_TRUE(store_->health(map_.key).ok());
  EXPECT_TRUE(store_->Append(MakeAppend(map_.key, 4, 1)).ok());
}

TEST_F(StoreFault, LogGivesItsSpaceBackOnAFullDisk) {
  ASSERT_TRUE(Commit(map_, 0, 3).ok());
  free_bytes_ = 0;
  faults_->disk_full = true;
  TrimBounds bounds{kStoreTime, MapUptime(0)};
  bounds.disk_is_low = true;
  EXPECT_EQ(ReasonOf(store_->Trim(map_, bounds)), reason::kDiskLow) << "of the database";
  EXPECT_TRUE(ReadAll(store_.get(), map_.key).empty()) << "and yet the log went";
  free_bytes_ = std::uint64_t{1} << 40;
  faults_->disk_full = false;
  EXPECT_TRUE(store_->Append(MakeAppend(map_.key, 4, 1)).ok());
}

}  // namespace
}  // namespace steadymap
