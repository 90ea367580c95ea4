#include "server/store_keys.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
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
    EXPECT_EQ(LeafOfStoreKey(LeafStoreKey(MapKey{random()}, a)), a);
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
  EXPECT_FALSE(LeafOfStoreKey("short"));
  EXPECT_FALSE(SequenceOfFrameKey("short"));
  EXPECT_FALSE(NameOfIndexKey(""));
  EXPECT_FALSE(NameOfIndexKey("nno-border"));
}

TEST(StoreKeys, FrameKeysSortBySequenceAndComeBack) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 1000; ++i) {
    const MapSequence a{random() >> (random() % 64)};
    const MapSequence b{random() >> (random() % 64)};
    EXPECT_EQ(FrameKey(MapKey{7}, a) < FrameKey(MapKey{7}, b), a < b);
    EXPECT_EQ(SequenceOfFrameKey(FrameKey(MapKey{random()}, a)), a);
  }
}

TEST(StoreKeys, RobotKeysSortByIdAndComeBack) {
  EXPECT_EQ(RobotOfKey(RobotKey(MapKey{7}, "forklift-2")), "forklift-2");
  EXPECT_EQ(RobotOfKey(RobotKey(MapKey{7}, "")), "");
  EXPECT_LT(RobotKey(MapKey{7}, "a"), RobotKey(MapKey{7}, "a-b"));
  EXPECT_EQ(RobotOfKey("short"), std::nullopt);
}

TEST(StoreKeys, MapRangeHoldsTheMapsKeysAndNoOther) {
  for (const std::uint64_t map : {1ULL, 255ULL, 256ULL, 0xFFFFULL, 1ULL << 40}) {
    const KeyRange range = MapRange(MapKey{map});
    const auto holds = [&](const std::string& key) {
      return range.begin <= key && key < range.end;
    };
    for (const MapKey other : {MapKey{map - 1}, MapKey{map}, MapKey{map + 1}}) {
      const bool own = other.value() == map;
      EXPECT_EQ(holds(FrameKey(other, MapSequence{0})), own);
      EXPECT_EQ(holds(FrameKey(other, MapSequence{~0ULL})), own);
      EXPECT_EQ(holds(SessionKey(other, {"zz", "zz"})), own);
      EXPECT_EQ(holds(LeafStoreKey(other, {ObjectId{~0ULL}, {-8, -8, -8}})), own);
      EXPECT_EQ(holds(ChangeKey(other, Revision{1})), own);
      EXPECT_EQ(holds(RobotKey(other, "zz")), own);
    }
  }
}

TEST(StoreKeys, NameIndexSortsAsNamesDo) {
  std::vector<MapName> names = {
      {"a", "z"}, {"a-b", "a"}, {"a", "hall"}, {"a", "hall-2"}, {"ab", "a"}, {"a0", "q"}};
  std::sort(names.begin(), names.end());
  for (std::size_t i = 1; i < names.size(); ++i) {
    EXPECT_LT(NameIndexKey(names[i - 1]), NameIndexKey(names[i]));
  }
  for (const MapName& name : names) EXPECT_EQ(NameOfIndexKey(NameIndexKey(name)), name);
}

}  // namespace
}  // namespace steadymap
