#include "server/store/disk/disk_space_gate.h"

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <rocksdb/file_system.h>

#include "tests/recovery/faulty_file_system.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

class DiskSpaceGateTest : public ::testing::Test {
 protected:
  std::unique_ptr<rocksdb::FSWritableFile> NewFile(const std::string& name) {
    std::unique_ptr<rocksdb::FSWritableFile> file;
    EXPECT_TRUE(gate_.NewWritableFile(folder_.path() / name, {}, &file, nullptr).ok());
    return file;
  }

  void AwaitWaiting(int threads) {
    while (gate_.waiting() != threads) std::this_thread::yield();
  }

  TemporaryFolder folder_;
  std::shared_ptr<FaultyFileSystem> disk_ = std::make_shared<FaultyFileSystem>();
  DiskSpaceGate gate_{disk_};
};

TEST_F(DiskSpaceGateTest, WritesWaitForRoomAndThenGoOnWhole) {
  const std::vector<std::unique_ptr<rocksdb::FSWritableFile>> files = [this] {
    std::vector<std::unique_ptr<rocksdb::FSWritableFile>> made;
    for (const char* name : {"a", "b", "c"}) made.push_back(NewFile(name));
    return made;
  }();
  disk_->disk_full = true;
  std::atomic<int> written = 0;
  std::vector<std::thread> writers;
  writers.reserve(files.size());
  for (const auto& file : files) {
    writers.emplace_back([&written, file = file.get()] {
      EXPECT_TRUE(file->Append("hello ", {}, nullptr).ok());
      EXPECT_TRUE(file->Append("world", {}, nullptr).ok());
      ++written;
    });
  }
  AwaitWaiting(3);
  EXPECT_EQ(written, 0);
  disk_->disk_full = false;
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(gate_.waiting(), 0);
  for (const auto& file : files) EXPECT_TRUE(file->Close({}, nullptr).ok());
  for (const char* name : {"a", "b", "c"}) {
    EXPECT_EQ(ContentOf(folder_.path() / name), "hello world");
  }
}

TEST_F(DiskSpaceGateTest, StopLetsThoseWhoWaitFailAndNobodyWaitsAfterIt) {
  const std::unique_ptr<rocksdb::FSWritableFile> file = NewFile("a");
  disk_->disk_full = true;
  std::thread writer([&file] { EXPECT_TRUE(file->Append("hello", {}, nullptr).IsNoSpace()); });
  AwaitWaiting(1);
  gate_.Stop();
  writer.join();
  EXPECT_TRUE(file->Append("again", {}, nullptr).IsNoSpace());
  EXPECT_EQ(gate_.waiting(), 0);
  EXPECT_TRUE(file->Close({}, nullptr).ok());
  EXPECT_EQ(ContentOf(folder_.path() / "a"), "") << "no write stops halfway";
}

TEST_F(DiskSpaceGateTest, OtherErrorsAreNotWaitedFor) {
  std::unique_ptr<rocksdb::FSWritableFile> file;
  const rocksdb::IOStatus missing =
      gate_.NewWritableFile(folder_.path() / "none" / "a", {}, &file, nullptr);
  EXPECT_FALSE(missing.ok());
  EXPECT_FALSE(missing.IsNoSpace());
  EXPECT_FALSE(gate_.RenameFile(folder_.path() / "none", folder_.path() / "b", {}, nullptr).ok());
  EXPECT_EQ(gate_.waiting(), 0);
}

}  // namespace
}  // namespace steadymap
