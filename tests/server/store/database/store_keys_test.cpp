#include "server/store/database/store_keys.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace steadymap {
namespace {

LeafKey RandomLeafKey(std::mt19937_64* random) {
  const auto coordinate = [&] {
    return static_cast<std::int32_t>((*random)() % 4 == 0 ? (*random)() : (*random)() % 64) &
           ~(kLeafSide - 1);
  };
  return {ObjectId{(*random)() % 3 == 0 ? (*random)() : (*random)() % 4},
          {coordinate(), coordinate(), coordinate()}};
}

TEST(StoreKeys, LeafKeysSortAsLeavesDoAndComeBack) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 5000; ++i) {
    const LeafKey a = RandomLeafKey(&random);
    const LeafKey b = RandomLeafKey(&random);
    EXPECT_EQ(PackLeafKey(a) < PackLeafKey(b), a < b);
    EXPECT_EQ(UnpackLeafKey(PackLeafKey(a)), a);
  }
}

TEST(StoreKeys, ExtremeCoordinatesComeBack) {
  constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max() & ~(kLeafSide - 1);
  const LeafKey key{ObjectId{std::numeric_limits<std::uint64_t>::max()}, {kLowest, kHighest, 0}};
  EXPECT_EQ(UnpackLeafKey(PackLeafKey(key)), key);
}

TEST(StoreKeys, UnpackRefusesWhatIsNoLeafKey) {
  const std::string packed = PackLeafKey({kBackgroundId, {8, -8, 16}});
  EXPECT_FALSE(UnpackLeafKey(packed.substr(1)));
  EXPECT_FALSE(UnpackLeafKey(packed + '\0'));
  std::string off_grid = packed;
  off_grid.back() = 1;
  EXPECT_FALSE(UnpackLeafKey(off_grid));
  EXPECT_FALSE(SequenceOfPoseKey("short"));
  EXPECT_FALSE(SequenceOfPoseKey(EventKey(EventNumber{3})));
}

TEST(StoreKeys, PoseKeysSortBySequenceAndComeBack) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 1000; ++i) {
    const MapSequence a{random() >> (random() % 64)};
    const MapSequence b{random() >> (random() % 64)};
    EXPECT_EQ(PoseKey(a) < PoseKey(b), a < b);
    EXPECT_EQ(SequenceOfPoseKey(PoseKey(a)), a);
  }
}

TEST(StoreKeys, RobotKeysSortAsSensorsDoAndComeBack) {
  std::vector<SensorName> sensors = {
      {"a", "z"}, {"a-b", "a"}, {"a", "top"}, {"a", "top-2"}, {"ab", "a"}, {"a0", "q"}};
  std::sort(sensors.begin(), sensors.end());
  for (std::size_t i = 1; i < sensors.size(); ++i) {
    EXPECT_LT(RobotKey(sensors[i - 1]), RobotKey(sensors[i]));
    EXPECT_LT(SessionKey({sensors[i - 1], "z"}), SessionKey({sensors[i], "a"}));
  }
  for (const SensorName& sensor : sensors) EXPECT_EQ(SensorOfRobotKey(RobotKey(sensor)), sensor);
  EXPECT_FALSE(SensorOfRobotKey(""));
  EXPECT_FALSE(SensorOfRobotKey("rno-border"));
}

TEST(StoreKeys, RangeHoldsTheKeysOfItsFamilyAndNoOther) {
  const std::vector<std::pair<Family, std::string>> keys = {
      {Family::kSession, SessionKey({{"zz", "zz"}, "zz"})},
      {Family::kObject, ObjectKey(ObjectId{~0ULL})},
      {Family::kEvent, EventKey(EventNumber{0})},
      {Family::kFree, FreeBlockKey({-8, -8, -8})},
      {Family::kRobot, RobotKey({"zz", "zz"})},
      {Family::kChange, ChangeKey(Revision{1})},
      {Family::kPose, PoseKey(MapSequence{~0ULL})},
      {Family::kMeta, HeadKey()}};
  for (const auto& [family, key] : keys) {
    for (const auto& [other, other_key] : keys) {
      const KeyRange range = RangeOf(other);
      EXPECT_EQ(range.begin <= key && key < range.end, family == other)
          << NameOf(family) << " in " << NameOf(other);
    }
  }
}

}  // namespace
}  // namespace steadymap
