#include "core/map/map_edits.h"

#include <string>

#include <gtest/gtest.h>

#include "core/types/error.h"
#include "core/volume/tsdf_codec.h"
#include "tests/support/analytic_map.h"

namespace steadymap {
namespace {

constexpr LeafOrigin kOrigin{8, 0, -16};
constexpr LeafOrigin kOtherOrigin{16, 0, -16};

/// Returns a leaf with one voxel.
std::string OneVoxelLeaf(int weight) {
  LeafVoxels voxels;
  voxels.observed[3] = 1;
  voxels.voxels[std::size_t{3} * 64] = Voxel(0, weight);
  return PackLeaf(ViewOf(voxels));
}

ObjectState StateOf(std::uint64_t id, std::uint64_t views) {
  ObjectState state;
  state.id = ObjectId(id);
  state.supporting_frames = views;
  return state;
}

class MapEditsTest : public ::testing::Test {
 protected:
  std::string LeafOf(const MapSnapshot& map, std::uint64_t object, LeafOrigin origin) const {
    return PackLeaf(FindLeaf(map, {ObjectId(object), origin}));
  }

  MapSnapshot map_;
  const std::string light_ = OneVoxelLeaf(1);
  const std::string heavy_ = OneVoxelLeaf(9);
};

TEST_F(MapEditsTest, AStateAloneKeepsTheVolume) {
  MapEdits first(&map_);
  first.SetState(StateOf(5, 1));
  ASSERT_TRUE(first.StoreLeaf({ObjectId(5), kOrigin}, light_).ok());
  first.Finish();
  const MapSnapshot before = map_;

  MapEdits second(&map_);
  second.SetState(StateOf(5, 2));
  second.Finish();
  EXPECT_EQ(map_.objects.at(ObjectId(5))->supporting_frames, 2U);
  EXPECT_EQ(map_.objects.at(ObjectId(5))->volume, before.objects.at(ObjectId(5))->volume)
      << "shared, since nobody wrote to it";
  EXPECT_EQ(before.objects.at(ObjectId(5))->supporting_frames, 1U);
}

TEST_F(MapEditsTest, AnObjectThatIsRemovedAndSetIsReplacedWhole) {
  MapEdits first(&map_);
  first.SetState(StateOf(5, 1));
  ASSERT_TRUE(first.StoreLeaf({ObjectId(5), kOrigin}, light_).ok());
  first.Finish();

  MapEdits second(&map_);
  second.RemoveObject(ObjectId(5));
  second.SetState(StateOf(5, 7));
  ASSERT_TRUE(second.StoreLeaf({ObjectId(5), kOtherOrigin}, heavy_).ok());
  second.Finish();
  EXPECT_EQ(map_.objects.at(ObjectId(5))->supporting_frames, 7U);
  EXPECT_EQ(LeafOf(map_, 5, kOrigin), "");
  EXPECT_EQ(LeafOf(map_, 5, kOtherOrigin), heavy_);
}

TEST_F(MapEditsTest, WhatIsSetAndThenRemovedIsGone) {
  MapEdits edits(&map_);
  edits.SetState(StateOf(5, 1));
  ASSERT_TRUE(edits.StoreLeaf({ObjectId(5), kOrigin}, light_).ok());
  edits.RemoveObject(ObjectId(5));
  edits.RemoveObject(ObjectId(6));
  edits.Finish();
  EXPECT_TRUE(map_.objects.empty());
}

TEST_F(MapEditsTest, ObjectsWithoutLeavesShareNothingThatIsWritten) {
  MapEdits edits(&map_);
  edits.SetState(StateOf(1, 1));
  edits.SetState(StateOf(2, 1));
  ASSERT_TRUE(edits.StoreLeaf({ObjectId(1), kOrigin}, light_).ok());
  edits.Finish();
  EXPECT_EQ(LeafOf(map_, 1, kOrigin), light_);
  EXPECT_EQ(LeafOf(map_, 2, kOrigin), "");
  EXPECT_EQ(map_.objects.at(ObjectId(2))->volume->leaf_count(), 0U);
}

TEST_F(MapEditsTest, ACopyOfTheMapNeverChanges) {
  map_ = testing::FloorMap();
  const LeafOrigin floor{0, 0, 0};
  const std::string leaf = LeafOf(map_, 0, floor);
  ASSERT_NE(leaf, "");
  const MapSnapshot before = map_;
  MapEdits edits(&map_);
  ASSERT_TRUE(edits.StoreLeaf({kBackgroundId, floor}, heavy_).ok());
  edits.Finish();
  EXPECT_EQ(LeafOf(map_, 0, floor), heavy_);
  EXPECT_EQ(LeafOf(before, 0, floor), leaf);
}

TEST_F(MapEditsTest, ALeafThatIsGoneMakesNoTile) {
  MapEdits edits(&map_);
  EXPECT_TRUE(edits.StoreLeaf({kBackgroundId, kOrigin}, "").ok());
  EXPECT_TRUE(edits.StoreLeaf({ObjectId(9), kOrigin}, "").ok());
  edits.Finish();
  EXPECT_EQ(map_.background.tile_count(), 0U);
  EXPECT_TRUE(map_.objects.empty());
}

TEST_F(MapEditsTest, DamagedLeavesAndThoseOfNoObjectAreRefused) {
  MapEdits edits(&map_);
  EXPECT_EQ(edits.StoreLeaf({kBackgroundId, kOrigin}, "garbage").code(),
            absl::StatusCode::kDataLoss);
  const absl::Status status = edits.StoreLeaf({ObjectId(9), kOrigin}, light_);
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(status.message(), "a leaf of object 9, which does not exist");
}

TEST_F(MapEditsTest, APatchLeavesTheOtherVoxelsOfItsLeaf) {
  const auto leaf_of = [](std::initializer_list<int> rows, int weight) {
    LeafVoxels voxels;
    for (const int row : rows) {
      voxels.observed[static_cast<std::size_t>(row)] = 1;
      voxels.voxels[static_cast<std::size_t>(row) * 64] = Voxel(0, weight);
    }
    return PackLeaf(ViewOf(voxels));
  };
  for (const std::uint64_t owner : {0U, 5U}) {
    MapEdits edits(&map_);
    if (owner != 0) edits.SetState(StateOf(owner, 1));
    ASSERT_TRUE(edits.StoreLeaf({ObjectId(owner), kOrigin}, leaf_of({3}, 9)).ok());
    edits.Finish();
    const MapSnapshot before = map_;
    // Applying a patch twice has the same effect as once.
    MapEdits patches(&map_);
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(patches.PatchLeaf({ObjectId(owner), kOrigin}, leaf_of({6}, 9)).ok());
    }
    patches.Finish();
    EXPECT_EQ(LeafOf(map_, owner, kOrigin), leaf_of({3, 6}, 9));
    EXPECT_EQ(LeafOf(before, owner, kOrigin), leaf_of({3}, 9)) << "a copy never changes";
  }
}

TEST_F(MapEditsTest, APatchOfWhatIsNotThereIsRefused) {
  MapEdits edits(&map_);
  edits.SetState(StateOf(5, 1));
  for (const std::uint64_t owner : {0U, 5U, 9U}) {
    const LeafKey key{ObjectId(owner), kOrigin};
    EXPECT_EQ(edits.PatchLeaf(key, light_).code(), absl::StatusCode::kDataLoss);
    EXPECT_EQ(edits.PatchLeaf(key, "garbage").code(), absl::StatusCode::kDataLoss);
  }
  edits.Finish();
  EXPECT_EQ(map_.background.tile_count(), 0U);

  MapEdits second(&map_);
  ASSERT_TRUE(second.StoreLeaf({kBackgroundId, kOrigin}, light_).ok());
  EXPECT_EQ(second.PatchLeaf({kBackgroundId, kOrigin}, "").code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace steadymap
