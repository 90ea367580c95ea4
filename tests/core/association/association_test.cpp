#include "core/association/association.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/association/cell_ownership.h"
#include "core/association/frame_clusters.h"
#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kScale;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::StateOf;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::WallVolume;

constexpr double kMaxRangeM = 5.0;

/// Stores a wall of one square metre in `object`. The wall is at `depth_m` along x and faces the
/// camera at the world origin.
void GiveWall(double depth_m, TrackedObject* object) {
  StoreVolume(WallVolume(depth_m, kScale), object);
}

/// One frame of a wall that fills the image, and its data association with the objects.
struct Look {
  Look(double depth_m,
       const std::vector<TrackedObject*>& objects,
       const Background& background = Background()) {
    cloud.Compute(RenderScene({Body(4, {depth_m, -4.0, -4.0}, {depth_m + 0.3, 4.0, 4.0})}, {}));
    samples.Compute(cloud);
    in_view = FindObjectsInView(objects, cloud, samples, kMaxRangeM);
    AssociateSamples(samples, in_view, background, kScale, FrameClusters({}, {}), &association);
  }

  std::size_t CountOwned(std::uint32_t owner) const {
    std::size_t count = 0;
    for (const std::uint32_t of_sample : association.owner) count += of_sample == owner ? 1U : 0U;
    return count;
  }

  SemanticCloud cloud{MapConfig()};
  SampleGrid samples;
  std::vector<ObjectInView> in_view;
  Association association;
};

TrackedObject NewObject(std::uint64_t id) {
  return {ObjectId(id), Eigen::Vector3d::Zero(), kScale};
}

TEST(AssociateSamples, GivesSamplesOnTheSurfaceToItsObject) {
  TrackedObject first = NewObject(1);
  GiveWall(2.0, &first);
  const Look look(2.0, {&first});
  for (std::size_t index = 0; index < look.samples.size(); ++index) {
    const Eigen::Vector3f& position_world = look.samples[index].position_world;
    if (!look.samples[index].is_valid()) continue;
    const float off_middle_m = std::max(std::abs(position_world.y()), std::abs(position_world.z()));
    if (off_middle_m < 0.48F) {
      EXPECT_EQ(look.association.owner[index], 1U);
      EXPECT_NEAR(look.association.distance_m[index], 0.0F, 0.002F);
    } else if (off_middle_m > 0.55F) {
      EXPECT_EQ(look.association.owner[index], Association::kNone);
    }
  }
}

TEST(AssociateSamples, PrefersTheCloserOfTwoSurfaces) {
  TrackedObject first = NewObject(1);
  TrackedObject second = NewObject(2);
  GiveWall(2.04, &first);
  GiveWall(1.99, &second);
  const Look look(2.0, {&first, &second});
  EXPECT_GT(look.CountOwned(2), 500U);
  EXPECT_EQ(look.CountOwned(1), 0U);
}

TEST(AssociateSamples, LeavesTheBackgroundWhatNoObjectExplains) {
  Background background;
  WallVolume(2.0, kScale).ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    LeafVoxels voxels;
    std::copy_n(leaf.distance_m, kLeafVoxels, voxels.distance_m.begin());
    std::copy_n(leaf.weight, kLeafVoxels, voxels.weight.begin());
    voxels.observed = leaf.observed;
    background.MutableTile(origin).StoreLeaf(origin, voxels);
  });
  const std::size_t in_background = Look(2.0, {}, background).CountOwned(kBackgroundOwner);
  EXPECT_GT(in_background, 500U);
  TrackedObject object = NewObject(1);
  GiveWall(2.03, &object);
  const Look look(2.0, {&object}, background);
  EXPECT_EQ(look.CountOwned(kBackgroundOwner), 0U) << "though it lies nearer";
  EXPECT_EQ(look.CountOwned(1), in_background);
  GiveWall(2.2, &object);
  EXPECT_EQ(Look(2.0, {&object}, background).CountOwned(kBackgroundOwner), in_background);
}

TEST(AssociateSamples, LeavesWhatStandsInFrontToNobodyAndSaysSo) {
  TrackedObject first = NewObject(1);
  GiveWall(2.0, &first);
  const Look look(1.88, {&first});
  EXPECT_EQ(look.CountOwned(1), 0U);
  std::size_t in_front = 0;
  for (const std::uint8_t is_in_front : look.association.is_in_front) in_front += is_in_front;
  EXPECT_GT(in_front, 500U);
}

TEST(FitTolerance, IsThatOfTheSensorUnlessTheMapIsFiner) {
  EXPECT_DOUBLE_EQ(FitTolerance(0.0F, 0.15), 0.045);
  EXPECT_DOUBLE_EQ(FitTolerance(0.0F, 0.6), 0.045);
  EXPECT_DOUBLE_EQ(FitTolerance(0.0F, 0.06), 0.018);
  EXPECT_GT(FitTolerance(3.0F, 0.15), FitTolerance(1.0F, 0.15));
}

TEST(ReleaseSamples, LeavesThemToNobodyAsNewSurface) {
  TrackedObject first = NewObject(1);
  GiveWall(2.0, &first);
  Look look(2.0, {&first});
  const Association before = look.association;
  ASSERT_GT(look.CountOwned(1), 0U);
  ReleaseSamples(1, &look.association);
  for (std::size_t index = 0; index < look.samples.size(); ++index) {
    const bool was_owned = before.owner[index] == 1;
    EXPECT_EQ(look.association.owner[index], was_owned ? Association::kNone : before.owner[index]);
    EXPECT_EQ(look.association.is_in_front[index], was_owned ? 1 : before.is_in_front[index]);
  }
}

TEST(FindObjectsInView, LeavesOutObjectsThatAreArchivedEmptyBehindOrFar) {
  TrackedObject first = NewObject(1);
  TrackedObject second = NewObject(2);
  EXPECT_TRUE(Look(2.0, {&first}).in_view.empty()) << "empty";
  GiveWall(2.0, &first);
  EXPECT_EQ(Look(2.0, {&first}).in_view.size(), 1U);
  StateOf(&first).status = ObjectStatus::kArchived;
  EXPECT_TRUE(Look(2.0, {&first}).in_view.empty()) << "archived";
  GiveWall(-2.0, &second);
  EXPECT_TRUE(Look(2.0, {&second}).in_view.empty()) << "behind";
  GiveWall(5.5, &second);
  EXPECT_TRUE(Look(2.0, {&second}).in_view.empty()) << "far";
}

TEST(GiveCellsToOwners, GivesCellsToTheOwnersOfTheirSamples) {
  TrackedObject first = NewObject(1);
  GiveWall(2.0, &first);
  Look look(2.0, {&first});
  GiveCellsToOwners(look.samples, look.association, &look.cloud);
  std::size_t owned = 0;
  for (const SurfaceCell& cell : look.cloud.cells()) {
    if (!(cell.weight > 0.0F)) continue;
    EXPECT_EQ(cell.owner, 1U) << "what nobody owns weighs nothing";
    ++owned;
  }
  // One sample spans two cells in each direction.
  EXPECT_GT(owned, 7 * look.CountOwned(1) / 2);
  EXPECT_LT(owned, 9 * look.CountOwned(1) / 2);
}

}  // namespace
}  // namespace steadymap
