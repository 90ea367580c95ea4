#include "server/resume_token.h"

#include <string>

#include <gtest/gtest.h>

#include "core/error.h"

namespace steadymap {
namespace {

const WatchScope kHallScope{MapKey(3), "incarnation-1", 42};
const WatchPosition kHallPosition{Revision(1ULL << 40), EventNumber(99)};

TEST(ResumeToken, HoldsThePosition) {
  const std::string token = MakeResumeToken(kHallScope, kHallPosition);
  EXPECT_LE(token.size(), 256U);
  EXPECT_EQ(ReadResumeToken(kHallScope, token).value(), kHallPosition);
}

TEST(ResumeToken, DamagedAnywhereIsRefused) {
  const std::string token = MakeResumeToken(kHallScope, kHallPosition);
  for (std::size_t i = 0; i < token.size(); ++i) {
    for (const int bit : {0, 3, 7}) {
      std::string damaged = token;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      const absl::Status status = ReadResumeToken(kHallScope, damaged).status();
      EXPECT_EQ(ReasonOf(status), reason::kBadResumeToken) << i;
      EXPECT_EQ(FieldOf(status), "resume_token");
    }
    EXPECT_EQ(ReasonOf(ReadResumeToken(kHallScope, token.substr(0, i)).status()),
              reason::kBadResumeToken);
  }
  EXPECT_EQ(ReasonOf(ReadResumeToken(kHallScope, token + "x").status()), reason::kBadResumeToken);
}

TEST(ResumeToken, OfAnotherFilterIsRefusedWithTheFilter) {
  const std::string token = MakeResumeToken(kHallScope, kHallPosition);
  const absl::Status status =
      ReadResumeToken({kHallScope.map, kHallScope.incarnation, 43}, token).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status));
  EXPECT_EQ(ReasonOf(status), reason::kBadResumeToken);
  EXPECT_EQ(FieldOf(status), "filter");
}

TEST(ResumeToken, OfAMapThatIsNoMoreAsksForAResync) {
  const std::string token = MakeResumeToken(kHallScope, kHallPosition);
  for (const WatchScope& scope :
       {WatchScope{MapKey(4), "incarnation-1", 42}, WatchScope{MapKey(3), "incarnation-2", 42}}) {
    const absl::Status status = ReadResumeToken(scope, token).status();
    EXPECT_TRUE(absl::IsOutOfRange(status));
    EXPECT_EQ(ReasonOf(status), reason::kRevisionCompacted);
  }
}

TEST(ResumeToken, FiltersHaveTheSameFingerprintOnlyIfTheyAreEqual) {
  v1::WatchFilter empty;
  v1::WatchFilter archived;
  archived.set_include_archived(true);
  v1::WatchFilter classes;
  classes.add_class_ids(1);
  v1::WatchFilter objects;
  objects.add_object_ids(1);
  EXPECT_EQ(FingerprintOf(classes), FingerprintOf(v1::WatchFilter(classes)));
  EXPECT_NE(FingerprintOf(empty), FingerprintOf(archived));
  EXPECT_NE(FingerprintOf(empty), FingerprintOf(classes));
  EXPECT_NE(FingerprintOf(classes), FingerprintOf(objects));
}

}  // namespace
}  // namespace steadymap
