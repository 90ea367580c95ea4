#include "server/store/model/sequence_set.h"

#include <cstdint>
#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kLargestSequence = std::numeric_limits<std::uint64_t>::max();

/// Reference implementation of the set.
class PlainSet {
 public:
  void Insert(std::uint64_t value) { values_.insert(value); }

  void InsertThrough(std::uint64_t last) {
    for (std::uint64_t value = 1; value <= last; ++value) values_.insert(value);
  }

  bool Contains(std::uint64_t value) const { return values_.contains(value); }

  std::uint64_t contiguous_end() const {
    std::uint64_t end = 0;
    while (values_.contains(end + 1)) ++end;
    return end;
  }

  std::uint64_t max() const { return values_.empty() ? 0 : *values_.rbegin(); }

  std::size_t interval_count() const {
    std::size_t count = 0;
    for (const std::uint64_t value : values_) count += values_.contains(value - 1) ? 0 : 1;
    return count;
  }

 private:
  std::set<std::uint64_t> values_;
};

void ExpectEqual(const SequenceSet& set, const PlainSet& plain, std::uint64_t largest) {
  ASSERT_EQ(set.contiguous_end().value(), plain.contiguous_end());
  ASSERT_EQ(set.max().value(), plain.max());
  ASSERT_EQ(set.interval_count(), plain.interval_count());
  for (std::uint64_t value = 0; value <= largest + 1; ++value) {
    ASSERT_EQ(set.Contains(ClientSequence{value}), plain.Contains(value)) << value;
  }
}

TEST(SequenceSet, AgreesWithAPlainSetOverRandomOperations) {
  constexpr std::uint64_t kRange = 120;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    SequenceSet set;
    PlainSet plain;
    for (int step = 0; step < 150; ++step) {
      const std::uint64_t value = 1 + random() % kRange;
      if (random() % 40 == 0) {
        set.InsertThrough(ClientSequence{value / 2});
        plain.InsertThrough(value / 2);
      } else {
        ASSERT_TRUE(set.Insert(ClientSequence{value}).ok());
        plain.Insert(value);
      }
      ASSERT_NO_FATAL_FAILURE(ExpectEqual(set, plain, kRange)) << "seed " << seed;
      const absl::StatusOr<SequenceSet> again = SequenceSet::Unpack(set.Pack());
      ASSERT_TRUE(again.ok()) << again.status();
      ASSERT_EQ(*again, set);
    }
  }
}

TEST(SequenceSet, AMillionInOrderTakeOneIntervalAndAFewBytes) {
  SequenceSet set;
  for (std::uint64_t value = 1; value <= 1'000'000; ++value) {
    ASSERT_TRUE(set.Insert(ClientSequence{value}).ok());
  }
  EXPECT_EQ(set.interval_count(), 1U);
  EXPECT_EQ(set.contiguous_end().value(), 1'000'000U);
  EXPECT_LT(set.Pack().size(), 10U);
}

TEST(SequenceSet, RefusesZero) {
  SequenceSet set;
  const absl::Status status = set.Insert(ClientSequence{0});
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReasonOf(status), reason::kBadSequence);
  EXPECT_EQ(set, SequenceSet());
}

TEST(SequenceSet, RefusesOneGapTooManyAndIsUnchanged) {
  SequenceSet set;
  for (std::uint64_t i = 0; i < SequenceSet::kMaxIntervals; ++i) {
    ASSERT_TRUE(set.Insert(ClientSequence{2 + 2 * i}).ok());
  }
  const SequenceSet before = set;
  const absl::Status status = set.Insert(ClientSequence{10'000});
  EXPECT_EQ(ReasonOf(status), reason::kBadSequence);
  EXPECT_EQ(set, before);
  EXPECT_TRUE(set.Insert(ClientSequence{3}).ok()) << "closing a gap must stay possible";
  EXPECT_TRUE(set.Insert(ClientSequence{10'000}).ok());
}

TEST(SequenceSet, HoldsTheLargestSequenceWithoutOverflow) {
  SequenceSet set;
  ASSERT_TRUE(set.Insert(ClientSequence{kLargestSequence}).ok());
  ASSERT_TRUE(set.Insert(ClientSequence{kLargestSequence - 1}).ok());
  EXPECT_EQ(set.interval_count(), 1U);
  EXPECT_EQ(set.max().value(), kLargestSequence);
  EXPECT_EQ(SequenceSet::Unpack(set.Pack()).value(), set);
  set.InsertThrough(ClientSequence{kLargestSequence});
  EXPECT_EQ(set.contiguous_end().value(), kLargestSequence);
}

TEST(SequenceSet, InsertThroughZeroChangesNothing) {
  SequenceSet set;
  set.InsertThrough(ClientSequence{0});
  EXPECT_EQ(set, SequenceSet());
}

TEST(SequenceSetUnpack, RefusesWhatPackCannotHaveWritten) {
  SequenceSet set;
  for (const std::uint64_t value : {1U, 2U, 9U, 300U}) {
    ASSERT_TRUE(set.Insert(ClientSequence{value}).ok());
  }
  const std::string packed = set.Pack();
  for (std::size_t length = 0; length < packed.size(); ++length) {
    EXPECT_FALSE(SequenceSet::Unpack(packed.substr(0, length)).ok()) << length;
  }
  EXPECT_FALSE(SequenceSet::Unpack(packed + '\0').ok());
  EXPECT_FALSE(SequenceSet::Unpack(std::string(11, '\xFF')).ok());
  EXPECT_FALSE(SequenceSet::Unpack(std::string("\x01\x00\x00", 3)).ok()) << "starts at 0";
  EXPECT_FALSE(SequenceSet::Unpack(std::string("\x02\x01\x00\x01\x00", 5)).ok()) << "adjacent";
}

TEST(SequenceSetUnpack, ReadsOnlyCanonicalSetsFromRandomBytes) {
  std::mt19937 random(7);
  for (int i = 0; i < 20'000; ++i) {
    std::string bytes(random() % 12, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random() % 4 == 0 ? random() : random() % 6);
    const absl::StatusOr<SequenceSet> set = SequenceSet::Unpack(bytes);
    if (!set.ok()) {
      EXPECT_EQ(set.status().code(), absl::StatusCode::kDataLoss);
      continue;
    }
    EXPECT_EQ(SequenceSet::Unpack(set->Pack()).value(), *set);
  }
}

}  // namespace
}  // namespace steadymap
