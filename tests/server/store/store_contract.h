#pragma once

#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "server/store/model/store.h"
#include "tests/server/store/store_builder.h"
#include "tests/support/memory_store.h"
#include "tests/support/temporary_folder.h"

/// Common parts of the store's contract suite.
namespace steadymap {

/// Kind of store under test.
enum class StoreKind { kRocks, kMemory };

inline constexpr MapUptime kForgetNone{0};

/// A store with small limits that can be reopened, as after a restart.
class StoreContract : public ::testing::TestWithParam<StoreKind> {
 protected:
  void SetUp() override { Reopen(); }

  /// Closes the store and opens it again, with all its maps.
  void Reopen() {
    if (GetParam() == StoreKind::kMemory) {
      if (memory_ == nullptr) memory_ = std::make_unique<MemoryStore>(options_);
      store_ = memory_->Share();
    } else {
      store_.reset();
      absl::StatusOr<std::unique_ptr<Store>> store = Store::Open(folder_.path() / "data", options_);
      ASSERT_TRUE(store.ok()) << store.status();
      store_ = *std::move(store);
    }
    const absl::StatusOr<std::vector<MapRecord>> maps = store_->ListMaps();
    for (const MapRecord& map : *maps) Load(map);
  }

  MapRecord Create(const std::string& name) {
    absl::StatusOr<MapRecord> record = store_->CreateMap(MakeMapRecord("acme", name));
    EXPECT_TRUE(record.ok()) << record.status();
    if (!record.ok()) return MapRecord();
    Load(*record);
    return *record;
  }

  void Append(const LogAppend& append) {
    const absl::Status status = store_->Append(append);
    ASSERT_TRUE(status.ok()) << status;
  }

  CommitMark Commit(MapKey map, const MapDelta& delta, MapUptime uptime = kStoreTime) {
    const absl::StatusOr<CommitMark> mark =
        store_->CommitRevision(map, delta, MakeDetails(delta, uptime));
    EXPECT_TRUE(mark.ok()) << mark.status();
    return mark.value_or(CommitMark());
  }

  /// Returns the error of a commit.
  absl::Status TryCommit(MapKey map, const MapDelta& delta) {
    return store_->CommitRevision(map, delta, MakeDetails(delta)).status();
  }

  StoredState Load(const MapRecord& record) {
    absl::StatusOr<StoredState> state = store_->LoadMap(record);
    EXPECT_TRUE(state.ok()) << state.status();
    return state.ok() ? *std::move(state) : StoredState();
  }

  StoreOptions SmallOptions() {
    StoreOptions options;
    options.kept_poses = 10;
    options.kept_change_lists = 3;
    // Each append starts a new file.
    options.log_segment_bytes = 1;
    return options;
  }

  TemporaryFolder folder_;
  StoreOptions options_ = SmallOptions();
  std::unique_ptr<MemoryStore> memory_;
  std::unique_ptr<Store> store_;
};

/// Returns the suffix of a test's name for both stores.
inline std::string NameOfStore(const ::testing::TestParamInfo<StoreKind>& suite) {
  return suite.param == StoreKind::kRocks ? "Rocks" : "Memory";
}

}  // namespace steadymap
