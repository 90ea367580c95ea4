// Tests the refusals at the opening of a store, and the detection of damage.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/error.h"
#include "server/store/database/store_keys.h"
#include "server/store/rocks_store.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;

absl::Status OpenStatus(const std::filesystem::path& folder) {
  return Store::Open(folder, StoreOptions()).status();
}

void WriteFile(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

void FlipBit(const std::filesystem::path& file, std::uint64_t bit) {
  std::string bytes = ContentOf(file);
  bytes.at(bit / 8) = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
  WriteFile(file, bytes);
}

/// Returns all files below a folder, sorted by name.
std::vector<std::filesystem::path> FilesOf(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
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

TEST(StoreOpen, OtherSchemasAreRefusedAndLeftAsTheyAre) {
  const TemporaryFolder folder;
  ASSERT_TRUE(OpenStatus(folder.path()).ok());
  for (const char* schema : {"1", "3"}) {
    const std::string text = std::string("steadymap store ") + schema + "\n";
    ASSERT_TRUE(MirroredFile(folder.path() / "schema").Write(text).ok());
    const std::string before = ContentOf(folder.path() / "schema");
    const absl::Status status = OpenStatus(folder.path());
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(status.message()), HasSubstr(std::string("schema ") + schema));
    EXPECT_EQ(ContentOf(folder.path() / "schema"), before);
  }
}

TEST(StoreOpen, TheFirstSchemaIsKnownByItsPlainMark) {
  const TemporaryFolder folder;
  WriteFile(folder.path() / "schema", "steadymap store 1\n");
  EXPECT_EQ(OpenStatus(folder.path()).code(), absl::StatusCode::kFailedPrecondition);
}

TEST(StoreOpen, GarbledSchemaIsDataLoss) {
  const TemporaryFolder folder;
  WriteFile(folder.path() / "schema", "hello\n");
  EXPECT_EQ(OpenStatus(folder.path()).code(), absl::StatusCode::kDataLoss);
}

TEST(StoreOpen, StoreWithoutItsMapsIsDataLossNotAnEmptyStore) {
  const TemporaryFolder folder;
  ASSERT_TRUE(OpenStatus(folder.path()).ok());
  std::filesystem::remove_all(folder.path() / "maps");
  const absl::Status status = OpenStatus(folder.path());
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), HasSubstr("maps is missing"));
}

/// Two maps with frames and leaves; tests damage the first.
class DamagedStore : public ::testing::Test {
 protected:
  void SetUp() override {
    Open();
    for (const char* name : {"bad", "good"}) {
      const MapRecord map = store_->CreateMap(MakeMapRecord("acme", name)).value();
      ASSERT_TRUE(store_->LoadMap(map).ok());
      ASSERT_TRUE(store_->Append(MakeAppend(map.key, 1, 3)).ok());
      Commit(map, MakeDelta(0, 2, {MakeLeaf(0, 0, 0, 1)}));
      ASSERT_TRUE(store_->Append(MakeAppend(map.key, 4, 1)).ok());
      maps_.push_back(map);
    }
  }

  void Open() {
    store_.reset();
    absl::StatusOr<std::unique_ptr<RocksStore>> store =
        RocksStore::Open(folder_.path(), StoreOptions(), RocksStore::Platform());
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  void Commit(const MapRecord& map, const MapDelta& delta) {
    const absl::Status status = store_->CommitRevision(map.key, delta, MakeDetails(delta)).status();
    ASSERT_TRUE(status.ok()) << status;
  }

  /// Flips one bit in the middle of a value of the bad map.
  void Damage(Family family, const std::string& key) {
    StateDatabase& database = store_->state_for_test(bad().key);
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
    const absl::StatusOr<StoredState> state = store_->LoadMap(good());
    ASSERT_TRUE(state.ok()) << state.status();
    EXPECT_EQ(LeavesOf(state->snapshot), std::vector<LeafChange>{MakeLeaf(0, 0, 0, 1)});
    EXPECT_EQ(ReadAll(store_.get(), good().key).size(), 4U);
    EXPECT_TRUE(store_->Append({good().key, kStoreTime, {}, {MakeSession("s", 1)}}).ok());
  }

  std::filesystem::path FolderOf(const MapRecord& map) const {
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path() / "maps")) {
      if (std::stoull(entry.path().filename()) == map.key.value()) return entry.path();
    }
    return {};
  }

  const MapRecord& bad() const { return maps_[0]; }

  const MapRecord& good() const { return maps_[1]; }

  TemporaryFolder folder_;
  std::unique_ptr<RocksStore> store_;
  std::vector<MapRecord> maps_;
};

TEST_F(DamagedStore, DamagedLeafIsNamedWithItsMapAndOthersAreServed) {
  const std::string key = PackLeafKey(MakeLeaf(0, 0, 0, 1).key);
  Damage(Family::kLeaf, key);
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "tenants/acme/maps/bad");
  ExpectDataLoss(store_->LoadMap(bad()).status(), KeyAsHex(key));
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, DamagedSessionIsNamedAndOthersAreServed) {
  Damage(Family::kSession, SessionKey({kStoreSensor, "session-1"}));
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "column family session");
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, DamagedHeadIsNamedAndOthersAreServed) {
  Damage(Family::kMeta, HeadKey());
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), KeyAsHex(HeadKey()));
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, MissingLogFileIsDataLossNotAShorterLog) {
  store_.reset();
  std::filesystem::remove_all(FolderOf(bad()) / "log");
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "lacks entry 3");
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, MissingDatabaseIsDataLossNotAnEmptyMap) {
  store_.reset();
  std::filesystem::remove_all(FolderOf(bad()) / "state");
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "is missing");
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, MissingWriteAheadLogIsDataLossNotAnOlderMap) {
  store_.reset();
  for (const std::filesystem::path& file : FilesOf(FolderOf(bad()) / "state")) {
    if (file.extension() == ".log") std::filesystem::remove(file);
  }
  Open();
  ExpectDataLoss(store_->LoadMap(bad()).status(), "tenants/acme/maps/bad");
  ExpectGoodMapIsServed();
}

TEST_F(DamagedStore, MapWithoutItsFolderKeepsItsName) {
  store_.reset();
  std::filesystem::remove_all(FolderOf(bad()));
  Open();
  const std::vector<MapRecord> listed = store_->ListMaps().value();
  ASSERT_EQ(listed.size(), 2U);
  EXPECT_EQ(listed[0].name, bad().name);
  ExpectDataLoss(listed[0].condition, "is missing");
  ExpectGoodMapIsServed();
  EXPECT_TRUE(store_->DeleteMap(bad().key).ok()) << "it can be deleted";
  EXPECT_TRUE(store_->CreateMap(MakeMapRecord("acme", "bad")).ok());
}

TEST_F(DamagedStore, DamagedRecordIsRestoredFromItsCopyAndQuarantinesWithoutOne) {
  store_.reset();
  FlipBit(FolderOf(bad()) / "record", 777);
  Open();
  EXPECT_TRUE(store_->ListMaps()->front().condition.ok());
  store_.reset();
  FlipBit(FolderOf(bad()) / "record.copy", 777);
  Open();
  EXPECT_TRUE(store_->ListMaps()->front().condition.ok());
  store_.reset();
  FlipBit(FolderOf(bad()) / "record", 777);
  FlipBit(FolderOf(bad()) / "record.copy", 777);
  Open();
  const std::vector<MapRecord> listed = store_->ListMaps().value();
  ASSERT_EQ(listed.size(), 2U);
  EXPECT_EQ(listed[0].name, bad().name);
  EXPECT_EQ(listed[0].key, bad().key);
  ExpectDataLoss(listed[0].condition, "record");
  ExpectDataLoss(store_->LoadMap(bad()).status(), "record");
  ExpectDataLoss(store_->Append(MakeAppend(bad().key, 5, 1)), "record");
  ExpectGoodMapIsServed();
  EXPECT_TRUE(store_->DeleteMap(bad().key).ok()) << "a damaged map can be deleted";
}

TEST_F(DamagedStore, LostCatalogIsMadeAnewFromTheFolders) {
  store_.reset();
  for (const char* file : {"catalog", "catalog.copy"}) FlipBit(folder_.path() / file, 500);
  Open();
  ASSERT_EQ(store_->ListMaps()->size(), 2U);
  EXPECT_EQ(store_->ListMaps()->front().name, bad().name);
  ExpectGoodMapIsServed();
  const MapRecord next = store_->CreateMap(MakeMapRecord("acme", "next")).value();
  EXPECT_GT(next.key, good().key);
}

TEST_F(DamagedStore, MapThatACrashKeptFromComingToBeIsGone) {
  const std::filesystem::path unfinished =
      FolderOf(bad()).parent_path() / "00000000000000000009.new";
  store_.reset();
  std::filesystem::create_directories(unfinished / "state");
  Open();
  EXPECT_FALSE(std::filesystem::exists(unfinished));
  EXPECT_EQ(store_->ListMaps()->size(), 2U);
}

TEST_F(DamagedStore, MapWhoseDeletionACrashInterruptedIsGone) {
  const std::filesystem::path folder = FolderOf(bad());
  store_.reset();
  WriteFile(folder / "deleted", "\n");
  Open();
  EXPECT_EQ(store_->ListMaps()->size(), 1U);
  EXPECT_FALSE(std::filesystem::exists(folder));
  EXPECT_GT(store_->CreateMap(MakeMapRecord("acme", "bad"))->key, good().key);
}

TEST_F(DamagedStore, FlippedBitHarmsItsMapAloneWhereverItIs) {
  // A table file, a closed log file, an open one, and a write-ahead log.
  StateDatabase& state = store_->state_for_test(bad().key);
  ASSERT_TRUE(state.database().Flush({}, state.handle(Family::kLeaf)).ok());
  std::vector<LeafChange> leaves;
  for (std::int32_t i = 1; i <= 20; ++i) {
    leaves.push_back(MakeLeaf(i, 0, 0, static_cast<std::uint32_t>(i)));
  }
  Commit(bad(), MakeDelta(2, 3, leaves));
  const std::filesystem::path folder = FolderOf(bad());
  store_.reset();
  const std::filesystem::path pristine = folder_.path().string() + "-pristine";
  std::filesystem::copy(folder_.path(), pristine, std::filesystem::copy_options::recursive);
  std::mt19937_64 random(12);
  int harmed = 0;
  int flips = 0;
  for (const std::filesystem::path& file : FilesOf(folder_.path())) {
    const std::uintmax_t bytes = std::filesystem::file_size(file);
    const bool is_good_maps = file.string().starts_with(FolderOf(good()).string());
    for (int i = 0; i < 6 && bytes > 0 && !is_good_maps; ++i, ++flips) {
      const std::string before = ContentOf(file);
      FlipBit(file, random() % (8 * bytes));
      Open();
      if (HasFatalFailure()) FAIL() << file;
      ExpectGoodMapIsServed();
      const absl::StatusOr<StoredState> state_of_bad = store_->LoadMap(bad());
      harmed += state_of_bad.ok() ? 0 : 1;
      if (state_of_bad.ok()) {
        // The served content equals the stored content.
        EXPECT_EQ(LeavesOf(state_of_bad->snapshot).size(), 21U) << file;
        EXPECT_EQ(state_of_bad->durable_head, MapSequence(4)) << file;
      }
      store_.reset();
      std::filesystem::remove_all(folder_.path());
      std::filesystem::copy(pristine, folder_.path(), std::filesystem::copy_options::recursive);
    }
  }
  std::filesystem::remove_all(pristine);
  EXPECT_GT(flips, 60);
  EXPECT_GT(harmed, 10) << "too few flips fell where they are noticed";
  Open();
}

TEST_F(DamagedStore, RestoredCopyGetsAnotherIncarnation) {
  const std::filesystem::path copy = folder_.path().string() + "-copy";
  const std::string incarnation = store_->ListMaps()->front().incarnation;
  store_.reset();
  std::filesystem::copy(folder_.path(), copy, std::filesystem::copy_options::recursive);
  Open();
  EXPECT_EQ(store_->ListMaps()->front().incarnation, incarnation) << "a restart is no restore";
  store_.reset();
  std::filesystem::remove_all(folder_.path());
  std::filesystem::copy(copy, folder_.path(), std::filesystem::copy_options::recursive);
  Open();
  const std::string restored = store_->ListMaps()->front().incarnation;
  EXPECT_NE(restored, incarnation);
  EXPECT_NE(store_->ListMaps()->back().incarnation, "incarnation-1");
  Open();
  EXPECT_EQ(store_->ListMaps()->front().incarnation, restored) << "once is enough";
  ExpectGoodMapIsServed();
  std::filesystem::remove_all(copy);
}

}  // namespace
}  // namespace steadymap
