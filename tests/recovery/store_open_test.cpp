// What opening a store refuses, and what it finds damaged.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "server/rocks_store.h"
#include "server/store_keys.h"
#include "tests/server/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;

absl::Status OpenStatus(const std::filesystem::path& folder) {
  return Store::Open(folder, StoreOptions()).status();
}

std::string ReadFile(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

void WriteFile(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

TEST(StoreOpen, MakesTheFolderWithItsParents) {
  const TemporaryFolder folder;
  EXPECT_TRUE(OpenStatus(folder.path() / "a" / "b").ok());
  EXPECT_TRUE(OpenStatus(folder.path() / "a" / "b").ok()) << "and opens it again";
}

TEST(StoreOpen, SecondOpenIsRefusedWhileTheFirstLives) {
  const TemporaryFolder folder;
  absl::StatusOr<std::unique_ptr<Store>> first = Store::Open(folder.path(), StoreOptions());
  ASSERT_TRUE(first.ok());
  const absl::Status status = OpenStatus(folder.path());
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr(folder.path().string()));
  first->reset();
  EXPECT_TRUE(OpenStatus(folder.path()).ok());
}

TEST(StoreOpen, FolderBelowAFileCannotBeMade) {
  const TemporaryFolder folder;
  WriteFile(folder.path() / "file", "text");
  const absl::Status status = OpenStatus(folder.path() / "file" / "data");
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("file/data"));
}

TEST(StoreOpen, NewerSchemaIsRefusedAndLeftAsItIs) {
  const TemporaryFolder folder;
  ASSERT_TRUE(OpenStatus(folder.path()).ok());
  WriteFile(folder.path() / "schema", "steadymap store 2\n");
  const std::filesystem::path log = folder.path() / "rocksdb" / "CURRENT";
  const std::string before = ReadFile(log);
  const absl::Status status = OpenStatus(folder.path());
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("schema 2"));
  EXPECT_EQ(ReadFile(log), before);
}

TEST(StoreOpen, GarbledSchemaIsDataLoss) {
  const TemporaryFolder folder;
  WriteFile(folder.path() / "schema", "hello\n");
  EXPECT_EQ(OpenStatus(folder.path()).code(), absl::StatusCode::kDataLoss);
}

/// Two maps with frames and leaves; tests damage the first.
class DamagedStore : public ::testing::Test {
 protected:
  void SetUp() override {
    Open();
    for (const char* name : {"bad", "good"}) {
      const MapRecord map = store_->CreateMap(MakeMapRecord("acme", name)).value();
      ASSERT_TRUE(store_->AppendFrames({MakeAppend(map.key, 1, 3)}).ok());
      ASSERT_TRUE(
          store_->CommitRevision(map.key, MakeDelta(0, 2, {MakeLeaf(0, 0, 0, 1)}), kStoreTime)
              .ok());
      maps_.push_back(map);
    }
  }

  void Open() {
    store_.reset();
    absl::StatusOr<std::unique_ptr<RocksStore>> store =
        RocksStore::Open(folder_.path(), StoreOptions(), nullptr);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  /// Flips one bit in the middle of a value.
  void Damage(Family family, const std::string& key) {
    StoreDatabase& database = store_->database_for_test();
    std::string value = database.Read(family, key).value();
    value[value.size() / 2] = static_cast<char>(value[value.size() / 2] ^ 0x10);
    ASSERT_TRUE(
        database.database().Put(rocksdb::WriteOptions(), database.handle(family), key, value).ok());
  }

  void ExpectDataLoss(const absl::Status& status, const std::string& named) {
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status;
    EXPECT_EQ(ReasonOf(status), reason::kChecksum);
    EXPECT_THAT(std::string(status.message()), HasSubstr(named));
  }

  void ExpectGoodMapIsServed() {
    EXPECT_EQ(LeavesOf(store_->LoadMap(maps_[1])->snapshot),
              std::vector<LeafChange>{MakeLeaf(0, 0, 0, 1)});
    EXPECT_EQ(ReadAll(store_.get(), maps_[1].key).size(), 3U);
  }

  const MapRecord& bad() const { return maps_[0]; }

  TemporaryFolder folder_;
  std::unique_ptr<RocksStore> store_;
  std::vector<MapRecord> maps_;
};

TEST_F(DamagedStore, DamagedLeafIsNamedWithItsMapAndOthersAreServed) {
  const std::string key = LeafStoreKey(bad().key, MakeLeaf(0, 0, 0, 1).key);
  Damage(Family::kLeaf, key);
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "tenants/acme/maps/bad");
  ExpectDataLoss(store_->LoadMap(bad()).status(), KeyForPeople(key));
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, DamagedSessionIsNamedAndOthersAreServed) {
  Damage(Family::kDedup, SessionKey(bad().key, {"robot-1", "session-1"}));
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "column family dedup");
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, DamagedFrameEndsTheReadingOfItsLog) {
  Damage(Family::kLog, FrameKey(bad().key, MapSequence{2}));
  int visited = 0;
  const absl::Status status = store_->ReadLog(bad().key, MapSequence{1}, [&](const LogFrame&) {
    ++visited;
    return absl::OkStatus();
  });
  ExpectDataLoss(status, "column family log");
  EXPECT_EQ(visited, 1);
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, MissingFrameIsDataLossNotAShorterLog) {
  StoreDatabase& database = store_->database_for_test();
  for (const std::uint64_t sequence : {3U, 2U}) {
    ASSERT_TRUE(database.database()
                    .Delete(rocksdb::WriteOptions(),
                            database.handle(Family::kLog),
                            FrameKey(bad().key, MapSequence{sequence}))
                    .ok());
    const absl::Status status = store_->ReadLog(
        bad().key, MapSequence{1}, [](const LogFrame&) { return absl::OkStatus(); });
    ExpectDataLoss(status, "lacks frame " + std::to_string(sequence));
  }
}

TEST_F(DamagedStore, DamagedMapRecordQuarantinesTheMap) {
  Damage(Family::kMeta, MapRecordKey(bad().key));
  Open();
  const std::vector<MapRecord> listed = store_->ListMaps().value();
  ASSERT_EQ(listed.size(), 2U);
  EXPECT_EQ(listed[0].name, bad().name);
  EXPECT_EQ(listed[0].key, bad().key);
  ExpectDataLoss(listed[0].condition, "column family meta");
  EXPECT_TRUE(listed[1].condition.ok());
  ExpectDataLoss(store_->LoadMap(bad()).status(), "meta");
  ExpectDataLoss(store_->AppendFrames({MakeAppend(bad().key, 4, 1)}), "meta");
  ExpectDataLoss(store_->CommitRevision(bad().key, MakeDelta(2, 3, {}), kStoreTime), "meta");
  ExpectGoodMapIsServed();
  EXPECT_TRUE(store_->DeleteMap(bad().key).ok()) << "a damaged map can be deleted";
  EXPECT_TRUE(store_->CreateMap(MakeMapRecord("acme", "bad")).ok());
}

TEST_F(DamagedStore, DamagedHeadQuarantinesTheMap) {
  for (const std::string& key : {LogHeadKey(bad().key), RevisionHeadKey(bad().key)}) {
    Damage(Family::kMeta, key);
    Open();
    ExpectDataLoss(store_->ListMaps()->front().condition, KeyForPeople(key));
    ExpectGoodMapIsServed();
    Damage(Family::kMeta, key);
  }
  Open();
  EXPECT_TRUE(store_->ListMaps()->front().condition.ok());
}

TEST_F(DamagedStore, FlippedBitsInATableFileDamageTheMapsInItAndNoOther) {
  // The bad map gets a table file of its own.
  StoreDatabase& database = store_->database_for_test();
  ASSERT_TRUE(database.database().Flush({}, database.handle(Family::kLeaf)).ok());
  std::vector<LeafChange> leaves;
  for (std::int32_t i = 1; i <= 50; ++i) {
    leaves.push_back(MakeLeaf(i, 0, 0, static_cast<std::uint32_t>(i)));
  }
  ASSERT_TRUE(store_->CommitRevision(bad().key, MakeDelta(2, 3, leaves), kStoreTime).ok());
  ASSERT_TRUE(database.database().Flush({}, database.handle(Family::kLeaf)).ok());
  std::vector<rocksdb::LiveFileMetaData> files;
  database.database().GetLiveFilesMetaData(&files);
  std::erase_if(files, [](const auto& table) { return table.column_family_name != "leaf"; });
  ASSERT_EQ(files.size(), 2U);
  const auto newest =
      std::max_element(files.begin(), files.end(), [](const auto& a, const auto& b) {
        return a.file_number < b.file_number;
      });
  const std::filesystem::path file = folder_.path() / "rocksdb" / newest->relative_filename;
  store_.reset();
  std::string bytes = ReadFile(file);
  ASSERT_GT(bytes.size(), 20'000U);
  bytes[10'000] = static_cast<char>(bytes[10'000] ^ 1);
  WriteFile(file, bytes);
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "tenants/acme/maps/bad");
  ExpectGoodMapIsServed();
}

}  // namespace
}  // namespace steadymap
