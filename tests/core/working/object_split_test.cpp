#include "core/working/object_split.h"

#include <array>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::StateOf;

/// Returns a leaf with uniform voxels.
LeafVoxels LeafWith(int distance_steps, int weight_units) {
  LeafVoxels voxels;
  voxels.voxels.fill(Voxel(distance_steps, weight_units));
  voxels.observed.fill(~std::uint64_t{0});
  return voxels;
}

/// Returns a wall that faces -x in the object frame, one leaf wide along y and z.
TrackedObject Wall(ObjectId id, const Eigen::Vector3d& position_world) {
  TrackedObject object(id, position_world, kScale);
  testing::StoreVolume(
      testing::MakeVolume([](const Eigen::Vector3d& point) { return 0.1 - point.x(); },
                          Box(Eigen::Vector3d::Zero(), Eigen::Vector3d(0.2, 0.39, 0.39)),
                          kScale,
                          [](const Eigen::Vector3d&) { return true; }),
      &object);
  return object;
}

void StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels, TrackedObject* object) {
  ObjectEdit edit = ObjectEdit::OfUnregistered(object);
  edit.StoreLeaf(origin, voxels);
}

void CopyInto(const TrackedObject& from, TrackedObject* into) {
  ObjectEdit edit = ObjectEdit::OfUnregistered(into);
  CopyVoxels(from, kScale, &edit);
}

void MoveGone(const GoneScores& scores, TrackedObject* object, TrackedObject* part) {
  ObjectEdit edit = ObjectEdit::OfUnregistered(object);
  ObjectEdit part_edit = ObjectEdit::OfUnregistered(part);
  MoveGoneVoxels(scores, &edit, &part_edit);
}

/// Returns all observed voxels of a volume, by leaf and offset.
std::map<std::pair<LeafOrigin, std::size_t>, Voxel> VoxelsOf(const TsdfGrid& volume) {
  std::map<std::pair<LeafOrigin, std::size_t>, Voxel> voxels;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (!IsSet(leaf.observed, offset)) continue;
      voxels[{origin, offset}] = leaf.voxels[offset];
    }
  });
  return voxels;
}

TEST(ShareLattice, HoldsOnlyForObjectsThatWereNotTurned) {
  MapObject a;
  MapObject b;
  EXPECT_TRUE(ShareLattice(a, b));
  b.T_world_object.yaw_rad = 0.1;
  EXPECT_FALSE(ShareLattice(a, b));
}

TEST(CopyVoxels, PutsVoxelsWhereTheyAreInTheWorld) {
  const TrackedObject from = Wall(ObjectId(2), {1.2, -0.8, 0.4});
  TrackedObject into(ObjectId(1), {0.4, 0.4, 0.0}, kScale);
  CopyInto(from, &into);
  EXPECT_TRUE(from.volume().FindLeaf({0, 0, 0}));
  EXPECT_TRUE(into.volume().FindLeaf({16, -24, 8}));
  EXPECT_EQ(into.volume().CountObservedVoxels(), from.volume().CountObservedVoxels());
  EXPECT_GT(into.surface().point_count(), 0U);
  const Cuboid& a = from.cuboid();
  const Cuboid& b = into.cuboid();
  EXPECT_LT((a.center_world - b.center_world).norm(), 1e-5);
  EXPECT_LT((a.size_m - b.size_m).norm(), 1e-5);
}

TEST(CopyVoxels, KeepsOfTwoScoresTheBetterOneThatLooksDecided) {
  const LeafOrigin in_from{0, 0, 0};
  const LeafOrigin in_into{8, 0, 0};
  TrackedObject from(ObjectId(2), {0.4, 0.0, 0.0}, kScale);
  TrackedObject into(ObjectId(1), {0.0, 0.0, 0.0}, kScale);
  StateOf(&from).evidence.MutableLeaf(in_from).score = {-2, 0, -2, 1};
  StateOf(&into).evidence.MutableLeaf(in_into).score = {0, -1, 1, 2};
  CopyInto(from, &into);
  const LeafEvidence* both = into.state().evidence.FindLeaf(in_into);
  ASSERT_NE(both, nullptr);
  EXPECT_EQ(both->score[0], -2);
  EXPECT_EQ(both->score[1], -1);
  EXPECT_EQ(both->score[2], 1);
  EXPECT_EQ(both->score[3], 2);
}

TEST(CopyVoxels, KeepsOfTwoVoxelsTheOneThatWasSeenBetter) {
  const LeafOrigin in_from{0, 0, 0};
  const LeafOrigin in_into{8, 0, 0};
  TrackedObject from(ObjectId(2), {0.4, 0.0, 0.0}, kScale);
  TrackedObject into(ObjectId(1), {0.0, 0.0, 0.0}, kScale);
  LeafVoxels better = LeafWith(100, 512);
  better.voxels[5] = Voxel(100, 64);
  better.voxels[6] = Voxel();
  ClearBit(6, &better.observed);
  StoreLeaf(in_from, better, &from);
  StoreLeaf(in_into, LeafWith(200, 256), &into);
  CopyInto(from, &into);
  LeafVoxels both;
  into.volume().LoadLeaf(in_into, &both);
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    const bool is_better = offset != 5 && offset != 6;
    EXPECT_EQ(both.voxels[offset], is_better ? Voxel(100, 512) : Voxel(200, 256)) << offset;
    EXPECT_TRUE(IsSet(both.observed, offset));
  }
}

TEST(CopyVoxels, KeepsColoursOfBothObjects) {
  TrackedObject from(ObjectId(2), {0.0, 0.0, 0.0}, kScale);
  TrackedObject into(ObjectId(1), {0.0, 0.0, 0.0}, kScale);
  LeafVoxels colored = LeafWith(100, 512);
  colored.color.fill(0x01102030U);
  colored.has_color = true;
  StoreLeaf({0, 0, 0}, colored, &from);
  StoreLeaf({0, 0, 0}, LeafWith(200, 256), &into);
  CopyInto(from, &into);
  LeafVoxels both;
  into.volume().LoadLeaf({0, 0, 0}, &both);
  EXPECT_EQ(both, colored);
}

TEST(CopyVoxels, KeepsTheBetterEvidence) {
  TrackedObject from = Wall(ObjectId(2), {0.4, 0.0, 0.0});
  TrackedObject into = Wall(ObjectId(1), {0.0, 0.0, 0.0});
  LeafEvidence& theirs = StateOf(&from).evidence.MutableLeaf({0, 0, 0});
  theirs.score[3] = 2;
  theirs.score[4] = -7;
  theirs.last_look = Timestamp::FromSeconds(50.0);
  LeafEvidence& ours = StateOf(&into).evidence.MutableLeaf({8, 0, 0});
  ours.score[3] = -3;
  ours.score[4] = -5;
  ours.last_look = Timestamp::FromSeconds(40.0);
  CopyInto(from, &into);
  const LeafEvidence* both = into.state().evidence.FindLeaf({8, 0, 0});
  ASSERT_NE(both, nullptr);
  EXPECT_EQ(both->score[3], 2);
  EXPECT_EQ(both->score[4], -5);
  EXPECT_EQ(both->last_look, Timestamp::FromSeconds(50.0));
  EXPECT_EQ(into.state().evidence.leaves.size(), 1U);
}

TEST(MoveGoneVoxels, MovesExactlyTheGoneCells) {
  TrackedObject object = Wall(ObjectId(1), {0.4, 0.0, 0.0});
  const auto before = VoxelsOf(object.volume());
  LeafEvidence& evidence = StateOf(&object).evidence.MutableLeaf({0, 0, 0});
  for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
    evidence.score[cell] = static_cast<std::int8_t>(cell % 4 < 2 ? -5 : -4);
  }
  TrackedObject part(ObjectId(2), {0.4, 0.0, 0.0}, kScale);
  const std::size_t points_before = object.surface().point_count();
  MoveGone({-5, -5}, &object, &part);

  auto after = VoxelsOf(object.volume());
  const auto moved = VoxelsOf(part.volume());
  for (const auto& [place, voxel] : after) EXPECT_GE(EvidenceCellOf(place.second) % 4, 2);
  for (const auto& [place, voxel] : moved) EXPECT_LT(EvidenceCellOf(place.second) % 4, 2);
  EXPECT_EQ(after.size() + moved.size(), before.size()) << "nothing lost or doubled";
  after.insert(moved.begin(), moved.end());
  EXPECT_EQ(after, before);
  EXPECT_EQ(object.surface().point_count() + part.surface().point_count(), points_before);
  const LeafEvidence* left = object.state().evidence.FindLeaf({0, 0, 0});
  const LeafEvidence* taken = part.state().evidence.FindLeaf({0, 0, 0});
  ASSERT_NE(taken, nullptr);
  for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) {
    EXPECT_EQ(left->score[cell], cell % 4 < 2 ? 0 : -4);
    EXPECT_EQ(taken->score[cell], cell % 4 < 2 ? -5 : 0);
  }
}

TEST(MoveGoneVoxels, TakesDoubtedCellsThatGoneOnesAreConnectedTo) {
  TrackedObject object = Wall(ObjectId(1), Eigen::Vector3d::Zero());
  LeafEvidence& evidence = StateOf(&object).evidence.MutableLeaf({0, 0, 0});
  // Cells along z: one gone, one missed, one found, and behind the found cell one missed.
  const std::array<std::int8_t, 4> scores = {-5, -3, 2, -3};
  for (std::size_t cell = 0; cell < kEvidenceCells; ++cell) evidence.score[cell] = scores[cell % 4];
  TrackedObject part(ObjectId(2), Eigen::Vector3d::Zero(), kScale);
  MoveGone({-5, -3}, &object, &part);
  for (const auto& [place, voxel] : VoxelsOf(part.volume())) {
    EXPECT_LT(EvidenceCellOf(place.second) % 4, 2);
  }
  for (const auto& [place, voxel] : VoxelsOf(object.volume())) {
    EXPECT_GE(EvidenceCellOf(place.second) % 4, 2);
  }
  const LeafEvidence* taken = part.state().evidence.FindLeaf({0, 0, 0});
  ASSERT_NE(taken, nullptr);
  EXPECT_EQ(taken->score[1], -3);
}

TEST(MoveGoneVoxels, TakesAWholeLeafAway) {
  TrackedObject object = Wall(ObjectId(1), Eigen::Vector3d::Zero());
  const auto before = VoxelsOf(object.volume());
  StateOf(&object).evidence.MutableLeaf({0, 0, 0}).score.fill(-9);
  TrackedObject part(ObjectId(2), Eigen::Vector3d::Zero(), kScale);
  MoveGone({-5, -5}, &object, &part);
  EXPECT_EQ(object.volume().leaf_count(), 0U);
  EXPECT_EQ(object.surface().point_count(), 0U);
  EXPECT_TRUE(object.bounds_object().isEmpty());
  EXPECT_EQ(VoxelsOf(part.volume()), before);
}

TEST(MoveGoneVoxels, ChangesNothingWhereNothingIsGone) {
  TrackedObject object = Wall(ObjectId(1), Eigen::Vector3d::Zero());
  const auto before = VoxelsOf(object.volume());
  StateOf(&object).evidence.MutableLeaf({0, 0, 0}).score.fill(-4);
  TrackedObject part(ObjectId(2), Eigen::Vector3d::Zero(), kScale);
  MoveGone({-5, -5}, &object, &part);
  EXPECT_EQ(VoxelsOf(object.volume()), before);
  EXPECT_EQ(part.volume().leaf_count(), 0U);
}

TEST(MoveGoneVoxels, ForgetsTheScoresOfCellsWithoutVoxels) {
  TrackedObject object = Wall(ObjectId(1), Eigen::Vector3d::Zero());
  StateOf(&object).evidence.MutableLeaf({80, 0, 0}).score.fill(-9);
  TrackedObject part(ObjectId(2), Eigen::Vector3d::Zero(), kScale);
  MoveGone({-5, -5}, &object, &part);
  EXPECT_EQ(object.state().evidence.FindLeaf({80, 0, 0})->score[0], 0);
  EXPECT_EQ(part.state().evidence.FindLeaf({80, 0, 0}), nullptr);
}

TEST(MoveGoneVoxels, LeavesAPublishedVolumeAlone) {
  TrackedObject object = Wall(ObjectId(1), Eigen::Vector3d::Zero());
  const std::shared_ptr<const MapObject> published = object.Publish();
  const auto before = VoxelsOf(*published->volume);
  StateOf(&object).evidence.MutableLeaf({0, 0, 0}).score.fill(-9);
  TrackedObject part(ObjectId(2), Eigen::Vector3d::Zero(), kScale);
  MoveGone({-5, -5}, &object, &part);
  EXPECT_EQ(VoxelsOf(*published->volume), before);
}

}  // namespace
}  // namespace steadymap
