// Tests the stored changes of commits and their retention.

#include <cstdint>
#include <map>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/error.h"
#include "tests/server/store/store_contract.h"

namespace steadymap {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr MapUptime kLater = std::chrono::seconds(10'000);

class StoreChanges : public StoreContract {
 protected:
  void SetUp() override {
    options_.change_list_age = std::chrono::seconds(3600);
    options_.change_list_grace = std::chrono::seconds(600);
    StoreContract::SetUp();
    map_ = Create("hall");
    Append(MakeAppend(map_.key, 1, 50));
  }

  void CommitLeaves(std::uint64_t from,
                    std::uint64_t to,
                    std::vector<LeafChange> leaves,
                    std::vector<ObjectChange> objects = {}) {
    MapDelta delta = MakeDelta(from, to, std::move(leaves));
    delta.objects = std::move(objects);
    marks_[Revision(to)] = Commit(map_.key, delta);
  }

  /// Returns the commit at a revision, or an unknown mark if there was none.
  CommitMark MarkOf(std::uint64_t revision) {
    const auto mark = marks_.find(Revision(revision));
    return mark != marks_.end() ? mark->second : CommitMark{Revision(revision), 0};
  }

  ChangeList Read(std::uint64_t from, std::uint64_t to) {
    const absl::StatusOr<ChangeList> changes =
        store_->ReadChanges(map_.key, MarkOf(from), Revision(to));
    EXPECT_TRUE(changes.ok()) << changes.status();
    return changes.value_or(ChangeList());
  }

  void ExpectCompacted(std::uint64_t from, std::uint64_t to) {
    const absl::Status status = store_->ReadChanges(map_.key, MarkOf(from), Revision(to)).status();
    EXPECT_TRUE(absl::IsOutOfRange(status)) << status;
    EXPECT_EQ(ReasonOf(status), reason::kRevisionCompacted);
  }

  void TrimAt(MapUptime uptime, std::optional<Revision> watched = std::nullopt) {
    ASSERT_TRUE(store_->Trim(map_, {uptime, kForgetNone, {}, watched}).ok());
  }

  MapRecord map_;
  std::map<Revision, CommitMark> marks_;
};

INSTANTIATE_TEST_SUITE_P(Stores,
                         StoreChanges,
                         ::testing::Values(StoreKind::kRocks, StoreKind::kMemory),
                         NameOfStore);

TEST_P(StoreChanges, AreTheUnionOfTheCommitsBetween) {
  const ObjectState object = MakeObject(3, 1);
  CommitLeaves(0, 2, {MakeLeaf(0, 0, 0, 1)});
  CommitLeaves(2, 9, {MakeLeaf(1, 0, 0, 2), MakeLeaf(2, 0, 0, 3)}, {{object.id, object}});
  CommitLeaves(9, 10, {MakeLeaf(1, 0, 0, 4)}, {{object.id, std::nullopt}});
  const ChangeList changes = Read(2, 10);
  EXPECT_EQ(changes.commits, 2U);
  EXPECT_THAT(changes.objects, ElementsAre(ObjectId(3)));
  EXPECT_THAT(changes.leaves, ElementsAre(MakeLeaf(1, 0, 0, 2).key, MakeLeaf(2, 0, 0, 3).key));
  EXPECT_EQ(Read(0, 10).commits, 3U);
  EXPECT_EQ(Read(0, 10).leaves.size(), 3U);
  EXPECT_EQ(Read(0, 2).leaves.size(), 1U);
}

TEST_P(StoreChanges, BetweenARevisionAndItselfAreNone) {
  CommitLeaves(0, 2, {MakeLeaf(0, 0, 0, 1)});
  for (const std::uint64_t revision : {0U, 2U}) EXPECT_EQ(Read(revision, revision), ChangeList());
}

TEST_P(StoreChanges, SurviveARestart) {
  CommitLeaves(0, 2, {MakeLeaf(0, 0, 0, 1)});
  CommitLeaves(2, 9, {MakeLeaf(1, 0, 0, 2)});
  const ChangeList before = Read(0, 9);
  Reopen();
  EXPECT_EQ(Read(0, 9), before);
}

TEST_P(StoreChanges, BetweenRevisionsThatWereNeverCommittedAreNotKnown) {
  CommitLeaves(0, 5, {MakeLeaf(0, 0, 0, 1)});
  CommitLeaves(5, 9, {MakeLeaf(0, 0, 0, 2)});
  ExpectCompacted(3, 9);
  ExpectCompacted(0, 7);
  ExpectCompacted(9, 12);
}

TEST_P(StoreChanges, BehindACommitOfAnotherHistoryAreNotKnown) {
  CommitLeaves(0, 2, {MakeLeaf(0, 0, 0, 1)});
  CommitLeaves(2, 4, {MakeLeaf(0, 0, 0, 2)});
  EXPECT_EQ(Read(2, 4).leaves.size(), 1U);
  ++marks_[Revision(2)].hash;
  ExpectCompacted(2, 4);
  EXPECT_EQ(Read(0, 4).commits, 2U);
}

TEST_P(StoreChanges, OfATrimmedSpanAreNeverGivenInPart) {
  options_.kept_change_lists = 2;
  if (GetParam() == StoreKind::kMemory) memory_ = nullptr;
  Reopen();
  map_ = GetParam() == StoreKind::kMemory ? Create("hall") : map_;
  if (GetParam() == StoreKind::kMemory) Append(MakeAppend(map_.key, 1, 50));
  for (std::uint64_t to = 1; to <= 5; ++to) {
    CommitLeaves(to - 1, to, {MakeLeaf(static_cast<std::int32_t>(to), 0, 0, 1)});
  }
  TrimAt(kStoreTime);
  EXPECT_EQ(Read(3, 5).leaves.size(), 2U);
  ExpectCompacted(2, 5);
  ExpectCompacted(0, 5);
  EXPECT_THAT(Read(5, 5).leaves, IsEmpty());
}

TEST_P(StoreChanges, WaitForALiveWatcherWithinItsGrace) {
  CommitLeaves(0, 1, {MakeLeaf(0, 0, 0, 1)});
  CommitLeaves(1, 2, {MakeLeaf(1, 0, 0, 1)});
  const MapUptime in_grace = kStoreTime + std::chrono::seconds(4000);
  TrimAt(in_grace, Revision(1));
  EXPECT_EQ(Read(1, 2).leaves.size(), 1U);
  ExpectCompacted(0, 2);
  TrimAt(in_grace, Revision(2));
  ExpectCompacted(1, 2);
}

TEST_P(StoreChanges, WaitForNobodyBeyondTheGrace) {
  CommitLeaves(0, 1, {MakeLeaf(0, 0, 0, 1)});
  TrimAt(kLater, Revision(0));
  ExpectCompacted(0, 1);
}

TEST_P(StoreChanges, OfAnUnknownMapAreNotFound) {
  EXPECT_TRUE(
      absl::IsNotFound(store_->ReadChanges(MapKey(77), CommitMark(), Revision(0)).status()));
}

}  // namespace
}  // namespace steadymap
