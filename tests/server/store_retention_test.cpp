// What a trim drops and what it keeps, held against both stores.

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/store_contract.h"

namespace steadymap {
namespace {

class StoreRetention : public StoreContract {};

INSTANTIATE_TEST_SUITE_P(Stores,
                         StoreRetention,
                         ::testing::Values(StoreKind::kRocks, StoreKind::kMemory),
                         NameOfStore);

TEST_P(StoreRetention, TrimByAgeCountsFromTheAppendByTheServersClock) {
  MapRecord map = Create("hall");
  map.frame_log_age = std::chrono::seconds(100);
  Append(MakeAppend(map.key, 1, 5, Timestamp::FromSeconds(1000.0)));
  Append(MakeAppend(map.key, 6, 5, Timestamp::FromSeconds(1050.0)));
  Commit(map.key, MakeDelta(0, 10, {}));
  const auto first_after = [&](double now_s) {
    EXPECT_TRUE(
        store_->Trim(map, {MapSequence{10}, Timestamp::FromSeconds(now_s), kForgetNone}).ok());
    const std::vector<LogFrame> frames = ReadAll(store_.get(), map.key);
    return frames.empty() ? 0 : frames.front().sequence.value();
  };
  EXPECT_EQ(first_after(1099.0), 1U);
  EXPECT_EQ(first_after(1100.0), 6U);
  EXPECT_EQ(first_after(900.0), 6U) << "a clock that was set back drops nothing";
  Reopen();
  EXPECT_EQ(first_after(1149.0), 6U);
  EXPECT_EQ(first_after(1150.0), 0U);
  EXPECT_EQ(Load(map).durable_head, MapSequence{10}) << "the head outlives the log";
  Append(MakeAppend(map.key, 11, 1));
}

TEST_P(StoreRetention, TrimByBytesKeepsNoMoreThanAllowed) {
  MapRecord map = Create("hall");
  map.frame_log_bytes = std::uint64_t{64} * 4;
  Append(MakeAppend(map.key, 1, 10));
  Commit(map.key, MakeDelta(0, 10, {}));
  ASSERT_TRUE(store_->Trim(map, {MapSequence{10}, kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 4U);
  map.frame_log_bytes -= 1;
  ASSERT_TRUE(store_->Trim(map, {MapSequence{10}, kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 3U);
  map.frame_log_bytes = 0;
  ASSERT_TRUE(store_->Trim(map, {MapSequence{10}, kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 0U);
}

TEST_P(StoreRetention, TrimNeverTouchesWhatIsNotIntegrated) {
  MapRecord map = Create("hall");
  map.frame_log_age = std::chrono::seconds(0);
  Append(MakeAppend(map.key, 1, 10));
  Commit(map.key, MakeDelta(0, 6, {}));
  ASSERT_TRUE(store_->Trim(map, {MapSequence{3}, kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).front().sequence, MapSequence{4});
  ASSERT_TRUE(store_->Trim(map, {MapSequence{10}, kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).front().sequence, MapSequence{7});
}

TEST_P(StoreRetention, PosesOutliveTheLogUpToTheirOwnBound) {
  MapRecord map = Create("hall");
  map.frame_log_age = std::chrono::seconds(0);
  Append(MakeAppend(map.key, 1, 25));
  Commit(map.key, MakeDelta(0, 25, {}));
  ASSERT_TRUE(store_->Trim(map, {MapSequence{25}, kStoreTime, kForgetNone}).ok());
  Reopen();
  const std::vector<FramePose> poses =
      store_->ReadPoses(map.key, MapSequence{1}, MapSequence{25}, 100).value();
  ASSERT_EQ(poses.size(), options_.kept_poses);
  EXPECT_EQ(poses.front().sequence, MapSequence{16});
}

TEST_P(StoreRetention, TrimForgetsIdleSessionsOnly) {
  const MapRecord map = Create("hall");
  Append({map.key,
          kStoreTime,
          {},
          {MakeSession("idle", 5, Timestamp::FromSeconds(10.0)),
           MakeSession("busy", 5, Timestamp::FromSeconds(20.0))}});
  ASSERT_TRUE(store_->Trim(map, {MapSequence{0}, kStoreTime, Timestamp::FromSeconds(20.0)}).ok());
  Reopen();
  ASSERT_EQ(Load(map).sessions.size(), 1U);
  EXPECT_EQ(Load(map).sessions.front().name.session, "busy");
}

}  // namespace
}  // namespace steadymap
