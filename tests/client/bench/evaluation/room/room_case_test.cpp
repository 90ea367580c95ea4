#include "client/bench/evaluation/room/room_case.h"

#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(ListRoomCases, BeginsWithTheDefaultAndIsTheSameEveryTime) {
  const std::vector<RoomCase> cases = ListRoomCases(RoomChange::kRemoved, 40, 3);
  ASSERT_EQ(cases.size(), 40U);
  EXPECT_TRUE(cases.front().variations.empty());
  std::size_t varied = 0;
  for (const RoomCase& room_case : cases) varied += room_case.variations.size();
  // Nine properties, each with a probability of a third.
  EXPECT_NEAR(static_cast<double>(varied), 39.0 * 9.0 / 3.0, 30.0);
  EXPECT_EQ(ListRoomCases(RoomChange::kRemoved, 40, 3).back().variations, cases.back().variations);
  EXPECT_NE(ListRoomCases(RoomChange::kRemoved, 40, 4)[5].seed, cases[5].seed);
}

TEST(ListRoomCases, GivesEveryCaseAnyOneVariation) {
  for (const std::string& name : RoomVariationNames()) {
    const std::vector<std::string> given = {name};
    const std::vector<RoomCase> cases = ListRoomCases(RoomChange::kMoved30Cm, 2, 1, given);
    ASSERT_EQ(cases.size(), 2U) << name;
    for (const RoomCase& room_case : cases) EXPECT_EQ(room_case.variations, given);
    EXPECT_NE(cases[0].seed, cases[1].seed);
  }
}

TEST(ListRoomCases, GivesVariationsTogether) {
  const std::vector<std::string> given = {"voxel-2cm", "30hz"};
  const std::vector<RoomCase> cases = ListRoomCases(RoomChange::kRemoved, 1, 1, given);
  ASSERT_EQ(cases.size(), 1U);
  EXPECT_EQ(cases.front().voxel_size_m, 0.02);
  EXPECT_EQ(cases.front().setting.frame_period_s, 1.0 / 30.0);
  EXPECT_EQ(cases.front().labels, RoomLabels::kClasses);
}

TEST(ListRoomCases, HasNoCaseOfAChangeThatDoesNotAllowAVariation) {
  const std::vector<std::string> large_voxels = {"voxel-10cm"};
  EXPECT_TRUE(ListRoomCases(RoomChange::kMugRemoved, 3, 1, large_voxels).empty());
}

}  // namespace
}  // namespace steadymap
