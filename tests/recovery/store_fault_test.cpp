// What a store does when the disk fails it.

#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <rocksdb/env.h>

#include "core/error.h"
#include "server/rocks_store.h"
#include "tests/recovery/faulty_file_system.h"
#include "tests/server/store_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

class StoreFault : public ::testing::Test {
 protected:
  void SetUp() override {
    Open(environment_.get());
    map_ = store_->CreateMap(MakeMapRecord("acme", "hall")).value();
    ASSERT_TRUE(store_->AppendFrames({MakeAppend(map_.key, 1, 3)}).ok());
  }

  void Open(rocksdb::Env* environment) {
    store_.reset();
    absl::StatusOr<std::unique_ptr<RocksStore>> store =
        RocksStore::Open(folder_.path(), StoreOptions(), environment);
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  void ExpectReadOnly(const absl::Status& status) {
    EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
    EXPECT_EQ(ReasonOf(status), reason::kStoreReadOnly);
  }

  /// Every write is refused, every read goes on, and a restart finds what was acknowledged.
  void ExpectReadOnlyUntilRestart() {
    const int syncs = faults_->syncs;
    ExpectReadOnly(store_->health());
    ExpectReadOnly(store_->AppendFrames({MakeAppend(map_.key, 4, 1)}));
    ExpectReadOnly(store_->CommitRevision(map_.key, MakeDelta(0, 3, {}), kStoreTime));
    ExpectReadOnly(store_->UpdateMap(map_));
    ExpectReadOnly(store_->DeleteMap(map_.key));
    ExpectReadOnly(store_->CreateMap(MakeMapRecord("acme", "other")).status());
    EXPECT_EQ(faults_->syncs, syncs) << "a failed sync must not be tried again";
    EXPECT_EQ(store_->ListMaps()->size(), 1U);
    EXPECT_GE(ReadAll(store_.get(), map_.key).size(), 3U);
    Open(nullptr);
    EXPECT_TRUE(store_->health().ok());
    const MapSequence head = store_->LoadMap(map_)->durable_head;
    EXPECT_GE(head, MapSequence{3});
    EXPECT_TRUE(store_->AppendFrames({MakeAppend(map_.key, head.value() + 1, 1)}).ok());
  }

  TemporaryFolder folder_;
  std::shared_ptr<FaultyFileSystem> faults_ = std::make_shared<FaultyFileSystem>();
  std::unique_ptr<rocksdb::Env> environment_ = rocksdb::NewCompositeEnv(faults_);
  std::unique_ptr<RocksStore> store_;
  MapRecord map_;
};

TEST_F(StoreFault, FailedSyncOfAnAppendIsRememberedAndNeverRetried) {
  faults_->fail_sync = true;
  ExpectReadOnly(store_->AppendFrames({MakeAppend(map_.key, 4, 2)}));
  faults_->fail_sync = false;
  ExpectReadOnlyUntilRestart();
}

TEST_F(StoreFault, FailedSyncOfACommitIsRememberedAndNeverRetried) {
  faults_->fail_sync = true;
  ExpectReadOnly(
      store_->CommitRevision(map_.key, MakeDelta(0, 2, {MakeLeaf(0, 0, 0, 1)}), kStoreTime));
  faults_->fail_sync = false;
  EXPECT_EQ(store_->ListMaps()->size(), 1U);
  ExpectReadOnlyUntilRestart();
}

TEST_F(StoreFault, FullDiskInTheMiddleOfAWriteLosesNothingAcknowledged) {
  faults_->disk_full = true;
  ExpectReadOnly(store_->AppendFrames({MakeAppend(map_.key, 4, 2)}));
  faults_->disk_full = false;
  ExpectReadOnlyUntilRestart();
}

TEST_F(StoreFault, AppendsAreRefusedBeforeTheDiskIsFullAndCommitsGoOn) {
  store_.reset();
  StoreOptions options;
  options.min_free_disk_bytes = std::uint64_t{1} << 62;
  store_ = RocksStore::Open(folder_.path(), options, nullptr).value();
  for (const absl::Status& status : {store_->AppendFrames({MakeAppend(map_.key, 4, 1)}),
                                     store_->CreateMap(MakeMapRecord("acme", "other")).status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(ReasonOf(status), reason::kDiskLow);
  }
  EXPECT_TRUE(store_->health().ok());
  EXPECT_TRUE(store_->CommitRevision(map_.key, MakeDelta(0, 3, {}), kStoreTime).ok());
}

}  // namespace
}  // namespace steadymap
