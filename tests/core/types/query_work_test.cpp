#include "core/types/query_work.h"

#include <cstdint>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(QueryWork, GoesOnAsLongAsItIsWanted) {
  QueryWork work;
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(work.Take());
  EXPECT_EQ(work.steps(), 10'000U);
  EXPECT_TRUE(work.status().ok());
}

TEST(QueryWork, EndsWithinAStretchOnceItIsCancelled) {
  const Cancellation cancellation;
  QueryWork work(cancellation, 1'000'000);
  for (int i = 0; i < 5'000; ++i) ASSERT_TRUE(work.Take());
  cancellation.Cancel();
  std::uint64_t afterwards = 0;
  while (work.Take()) ++afterwards;
  EXPECT_LT(afterwards, QueryWork::kStepsPerCheck);
  EXPECT_TRUE(absl::IsCancelled(work.status()));
  EXPECT_FALSE(work.Take()) << "for good";
}

TEST(QueryWork, AsksNoMoreOftenThanOnceAStretch) {
  std::uint64_t asked = 0;
  QueryWork work(Cancellation([&asked] {
                   ++asked;
                   return false;
                 }),
                 1'000'000);
  for (std::uint64_t i = 0; i < 10 * QueryWork::kStepsPerCheck; ++i) work.Take();
  EXPECT_EQ(asked, 10U);
}

TEST(QueryWork, AllowsTheStepsOfItsBudgetAndNoneMore) {
  for (const std::uint64_t budget : {0U, 1U, 1023U, 1024U, 1025U, 5000U}) {
    QueryWork work(Cancellation(), budget);
    std::uint64_t taken = 0;
    while (work.Take()) ++taken;
    EXPECT_EQ(taken, budget);
    EXPECT_TRUE(absl::IsResourceExhausted(work.status()));
  }
  QueryWork at_once(Cancellation(), 100);
  EXPECT_FALSE(at_once.Take(101));
}

}  // namespace
}  // namespace steadymap
