// Tests the change lists of RocksStore through its internal state.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/store/database/store_keys.h"
#include "server/store/database/store_records.h"
#include "server/store/rocks_store.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

class ChangeLists : public ::testing::Test {
 protected:
  void SetUp() override {
    StoreOptions options;
    options.kept_change_lists = 3;
    options.change_list_age = std::chrono::seconds(100);
    store_ = RocksStore::Open(folder_.path(), options, RocksStore::Platform()).value();
    map_ = store_->CreateMap(MakeMapRecord("acme", "hall")).value();
    ASSERT_TRUE(store_->LoadMap(map_).ok());
    ASSERT_TRUE(store_->Append(MakeAppend(map_.key, 1, 50)).ok());
  }

  void Commit(std::uint64_t from, std::uint64_t to, int uptime_s) {
    const MapDelta delta = MakeDelta(from, to, {MakeLeaf(-3, 0, 2, 1), MakeLeaf(1, 0, 0, 2)});
    ASSERT_TRUE(
        store_->CommitRevision(map_.key, delta, MakeDetails(delta, std::chrono::seconds(uptime_s)))
            .ok());
  }

  void Trim(int uptime_s) {
    ASSERT_TRUE(store_->Trim(map_, {std::chrono::seconds(uptime_s), MapUptime(0)}).ok());
  }

  /// Returns the revisions in 1..50 with a change list.
  std::vector<std::uint64_t> Kept() {
    std::vector<std::uint64_t> kept;
    for (std::uint64_t revision = 1; revision <= 50; ++revision) {
      const std::string key = ChangeKey(Revision{revision});
      if (store_->state_for_test(map_.key).Read(Family::kChange, key).ok())
        kept.push_back(revision);
    }
    return kept;
  }

  TemporaryFolder folder_;
  std::unique_ptr<RocksStore> store_;
  MapRecord map_;
};

TEST_F(ChangeLists, NameTheLeavesOfTheirCommit) {
  Commit(0, 7, 1000);
  const std::string key = ChangeKey(Revision{7});
  const std::string value = store_->state_for_test(map_.key).Read(Family::kChange, key).value();
  storage::v1::ChangeRecord change;
  ASSERT_TRUE(UnsealRecord({"change", key}, value, &change).ok());
  ASSERT_EQ(change.leaf_keys().size(), 2 * kPackedLeafKeyBytes);
  EXPECT_EQ(UnpackLeafKey(change.leaf_keys().substr(0, kPackedLeafKeyBytes)),
            MakeLeaf(-3, 0, 2, 1).key);
  EXPECT_EQ(UnpackLeafKey(change.leaf_keys().substr(kPackedLeafKeyBytes)),
            MakeLeaf(1, 0, 0, 2).key);
}

TEST_F(ChangeLists, NoMoreAreKeptThanAllowedHoweverFarRevisionsLieApart) {
  Commit(0, 1, 1000);
  Commit(1, 20, 1000);
  Commit(20, 21, 1000);
  Trim(1000);
  EXPECT_EQ(Kept(), (std::vector<std::uint64_t>{1, 20, 21}));
  Commit(21, 50, 1000);
  Trim(1000);
  EXPECT_EQ(Kept(), (std::vector<std::uint64_t>{20, 21, 50}));
}

TEST_F(ChangeLists, OldOnesAreDropped) {
  Commit(0, 10, 1000);
  Commit(10, 20, 1050);
  Trim(1099);
  EXPECT_EQ(Kept(), (std::vector<std::uint64_t>{10, 20}));
  Trim(1100);
  EXPECT_EQ(Kept(), (std::vector<std::uint64_t>{20}));
  Trim(1150);
  EXPECT_TRUE(Kept().empty());
}

}  // namespace
}  // namespace steadymap
