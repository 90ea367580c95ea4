#include "server/process/frame_budget.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

using Reservation = FrameBudget::Reservation;

TEST(FrameBudget, GivesBackWhatAReservationHeld) {
  FrameBudget budget(100);
  const auto map = budget.OpenAccount(100);
  {
    const std::optional<Reservation> held = FrameBudget::TryReserve(map, 60);
    ASSERT_TRUE(held);
    EXPECT_EQ(budget.used_bytes(), 60U);
    EXPECT_FALSE(FrameBudget::TryReserve(map, 41));
  }
  EXPECT_EQ(budget.used_bytes(), 0U);
  EXPECT_TRUE(FrameBudget::TryReserve(map, 100));
}

TEST(FrameBudget, OneMapCannotTakeAnothersShare) {
  FrameBudget budget(100);
  const auto busy = budget.OpenAccount(60);
  const auto quiet = budget.OpenAccount(60);
  const std::optional<Reservation> held = FrameBudget::TryReserve(busy, 60);
  EXPECT_FALSE(FrameBudget::TryReserve(busy, 1));
  EXPECT_TRUE(FrameBudget::TryReserve(quiet, 40));
  EXPECT_FALSE(FrameBudget::TryReserve(quiet, 41));
}

TEST(FrameBudget, FrameLargerThanTheLimitIsLetInAlone) {
  FrameBudget budget(100);
  const auto map = budget.OpenAccount(100);
  std::optional<Reservation> huge = FrameBudget::TryReserve(map, 1000);
  ASSERT_TRUE(huge);
  EXPECT_FALSE(FrameBudget::TryReserve(map, 1));
  huge.reset();
  const std::optional<Reservation> small = FrameBudget::TryReserve(map, 1);
  EXPECT_FALSE(FrameBudget::TryReserve(map, 1000));
}

TEST(FrameBudget, WaitersOfAMapAreServedInTheirOrder) {
  FrameBudget budget(100);
  const auto map = budget.OpenAccount(100);
  std::optional<Reservation> held = FrameBudget::TryReserve(map, 100);
  std::vector<int> order;
  std::vector<Reservation> granted;
  const auto grant = [&](int id) {
    return [&order, &granted, id](Reservation reservation) {
      order.push_back(id);
      granted.push_back(std::move(reservation));
    };
  };
  FrameBudget::Reserve(map, 80, grant(1));
  FrameBudget::Reserve(map, 10, grant(2));
  FrameBudget::Reserve(map, 20, grant(3));
  EXPECT_TRUE(order.empty());
  // New requests wait behind the earlier ones even if memory is free.
  held.reset();
  EXPECT_EQ(order, (std::vector<int>{1, 2}));
  EXPECT_FALSE(FrameBudget::TryReserve(map, 5));
  {
    // Moved out first: the release appends to the list.
    const Reservation released = std::move(granted.front());
    granted.erase(granted.begin());
  }
  EXPECT_EQ(order, (std::vector<int>{1, 2, 3}));
}

TEST(FrameBudget, FullMapDoesNotHoldUpOthers) {
  FrameBudget budget(100);
  const auto full = budget.OpenAccount(10);
  const auto other = budget.OpenAccount(100);
  const std::optional<Reservation> held = FrameBudget::TryReserve(full, 10);
  bool full_granted = false;
  bool other_granted = false;
  FrameBudget::Reserve(full, 10, [&](Reservation) { full_granted = true; });
  FrameBudget::Reserve(other, 50, [&](Reservation) { other_granted = true; });
  EXPECT_FALSE(full_granted);
  EXPECT_TRUE(other_granted);
}

TEST(FrameBudget, ClosedAccountDropsItsWaiters) {
  FrameBudget budget(10);
  const auto map = budget.OpenAccount(10);
  std::optional<Reservation> held = FrameBudget::TryReserve(map, 10);
  auto token = std::make_shared<int>(0);
  FrameBudget::Reserve(map, 10, [token](Reservation) { ++*token; });
  FrameBudget::Close(map);
  EXPECT_EQ(token.use_count(), 1);
  held.reset();
  EXPECT_EQ(*token, 0);
}

TEST(FrameBudget, RaisedLimitServesWaiters) {
  FrameBudget budget(10);
  const auto map = budget.OpenAccount(100);
  const std::optional<Reservation> held = FrameBudget::TryReserve(map, 10);
  bool granted = false;
  FrameBudget::Reserve(map, 10, [&](Reservation) { granted = true; });
  EXPECT_FALSE(granted);
  budget.SetTotal(20);
  EXPECT_TRUE(granted);
}

TEST(FrameBudget, RandomUseNeverExceedsTheLimitsAndStarvesNobody) {
  std::mt19937 random(7);
  FrameBudget budget(1000);
  const std::vector accounts = {budget.OpenAccount(400), budget.OpenAccount(700)};
  std::vector<Reservation> held;
  int granted = 0;
  constexpr int kRequests = 2000;
  for (int i = 0; i < kRequests; ++i) {
    FrameBudget::Reserve(accounts[random() % 2], 1 + random() % 300, [&](Reservation reservation) {
      held.push_back(std::move(reservation));
      ++granted;
    });
    EXPECT_LE(budget.used_bytes(), 1000U);
    if (random() % 2 == 0 && !held.empty()) {
      // Moved out first: the release may append to the list.
      const Reservation released = std::move(held.front());
      held.erase(held.begin());
    }
  }
  while (!held.empty()) {
    const Reservation released = std::move(held.front());
    held.erase(held.begin());
  }
  EXPECT_EQ(granted, kRequests);
  EXPECT_EQ(budget.used_bytes(), 0U);
}

}  // namespace
}  // namespace steadymap
