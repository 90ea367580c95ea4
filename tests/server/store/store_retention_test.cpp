// Tests that a trim drops and keeps the right data, with both stores.

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/server/store/store_contract.h"

namespace steadymap {
namespace {

class StoreRetention : public StoreContract {};

INSTANTIATE_TEST_SUITE_P(Stores,
                         StoreRetention,
                         ::testing::Values(StoreKind::kRocks, StoreKind::kMemory),
                         NameOfStore);

TEST_P(StoreRetention, TrimByAgeCountsInTheMapsUptimeFromTheAppend) {
  MapRecord map = Create("hall");
  map.frame_log_age = std::chrono::seconds(100);
  Append(MakeAppend(map.key, 1, 5, std::chrono::seconds(1000)));
  Append(MakeAppend(map.key, 6, 5, std::chrono::seconds(1050)));
  Commit(map.key, MakeDelta(0, 10, {}));
  const auto first_after = [&](int uptime_s) {
    EXPECT_TRUE(store_->Trim(map, {std::chrono::seconds(uptime_s), kForgetNone}).ok());
    const std::vector<LogEntry> entries = ReadAll(store_.get(), map.key);
    return entries.empty() ? 0 : entries.front().sequence.value();
  };
  EXPECT_EQ(first_after(1099), 1U);
  // A file is dropped once the next file is old enough.
  EXPECT_EQ(first_after(1149), 1U);
  EXPECT_EQ(first_after(1150), 0U);
  Reopen();
  EXPECT_EQ(Load(map).durable_head, MapSequence{10}) << "the head outlives the log";
  Append(MakeAppend(map.key, 11, 1));
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 1U);
}

TEST_P(StoreRetention, UptimeIsKnownUpToTheLastWriteAndTenMinutes) {
  const MapRecord map = Create("hall");
  Append(MakeAppend(map.key, 1, 1, std::chrono::hours(1)));
  const auto known_after = [&](std::chrono::minutes uptime) {
    EXPECT_TRUE(store_->Trim(map, {uptime, kForgetNone}).ok());
    Reopen();
    return Load(map).uptime;
  };
  EXPECT_GE(known_after(std::chrono::minutes(65)), std::chrono::hours(1));
  EXPECT_GE(known_after(std::chrono::minutes(100)), std::chrono::minutes(90));
  EXPECT_LE(known_after(std::chrono::minutes(101)), std::chrono::minutes(101));
}

TEST_P(StoreRetention, TrimByBytesKeepsNoMoreThanAllowed) {
  MapRecord map = Create("hall");
  for (std::uint64_t i = 1; i <= 10; ++i) {
    LogAppend append{map.key, kStoreTime, {MakeLogEntry(i, 10'000)}, {}};
    Append(append);
  }
  Commit(map.key, MakeDelta(0, 10, {}));
  map.frame_log_bytes = 45'000;
  ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 4U);
  map.frame_log_bytes = 35'000;
  ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 3U);
  map.frame_log_bytes = 0;
  ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 0U);
}

TEST_P(StoreRetention, LowDiskDropsAllThatIsIntegratedAndNothingElse) {
  MapRecord map = Create("hall");
  for (std::uint64_t i = 1; i <= 10; ++i) Append(MakeAppend(map.key, i, 1));
  Commit(map.key, MakeDelta(0, 6, {}));
  TrimBounds bounds{kStoreTime, kForgetNone};
  ASSERT_TRUE(store_->Trim(map, bounds).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 10U) << "retention wants all of them";
  bounds.disk_is_low = true;
  ASSERT_TRUE(store_->Trim(map, bounds).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).front().sequence, MapSequence{7});
  Reopen();
  EXPECT_EQ(Load(map).sessions.front().settled.contiguous_end(), ClientSequence{10});
  EXPECT_EQ(Load(map).durable_head, MapSequence{10});
}

TEST_P(StoreRetention, TrimNeverTouchesWhatIsNotIntegrated) {
  MapRecord map = Create("hall");
  map.frame_log_age = std::chrono::seconds(0);
  for (std::uint64_t i = 1; i <= 10; ++i) Append(MakeAppend(map.key, i, 1));
  ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).size(), 10U);
  Commit(map.key, MakeDelta(0, 6, {}));
  ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  EXPECT_EQ(ReadAll(store_.get(), map.key).front().sequence, MapSequence{7});
}

TEST_P(StoreRetention, PosesOutliveTheLogUpToTheirOwnBound) {
  MapRecord map = Create("hall");
  map.frame_log_age = std::chrono::seconds(0);
  Append(MakeAppend(map.key, 1, 25));
  Commit(map.key, MakeDelta(0, 25, {}));
  ASSERT_TRUE(store_->Trim(map, {kStoreTime, kForgetNone}).ok());
  Reopen();
  EXPECT_TRUE(ReadAll(store_.get(), map.key).empty());
  const std::vector<FramePose> poses =
      store_->ReadPoses(map.key, MapSequence{1}, MapSequence{25}, 100).value();
  ASSERT_EQ(poses.size(), options_.kept_poses);
  EXPECT_EQ(poses.front().sequence, MapSequence{16});
}

TEST_P(StoreRetention, TrimForgetsIdleSessionsThatNobodyUses) {
  const MapRecord map = Create("hall");
  const SessionRecord in_use = MakeSession("in-use", 5, std::chrono::seconds(10));
  Append({map.key,
          kStoreTime,
          {},
          {MakeSession("idle", 5, std::chrono::seconds(10)),
           MakeSession("busy", 5, std::chrono::seconds(20)),
           in_use}});
  for (int restart = 0; restart < 2; ++restart) {
    ASSERT_TRUE(store_->Trim(map, {kStoreTime, std::chrono::seconds(20), {in_use.name}}).ok());
    ASSERT_EQ(Load(map).sessions.size(), 2U);
    EXPECT_EQ(Load(map).sessions[0].name.session, "busy");
    EXPECT_EQ(Load(map).sessions[1].name.session, "in-use");
    Reopen();
  }
}

}  // namespace
}  // namespace steadymap
