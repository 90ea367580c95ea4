#include "core/association/association.h"

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/association/cell_ownership.h"
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

/// One frame of a wall that fills the image, and the objects in its view.
struct Look {
  Look(double depth_m, const std::vector<TrackedObject*>& objects) {
    cloud.Compute(RenderScene({Body(4, {depth_m, -4.0, -4.0}, {depth_m + 0.3, 4.0, 4.0})}, {}));
    samples.Compute(cloud);
    in_view = FindObjectsInView(objects, cloud, samples, kMaxRangeM);
  }

  SemanticCloud cloud{MapConfig()};
  SampleGrid samples;
  std::vector<ObjectInView> in_view;
};

TrackedObject NewObject(std::uint64_t id) {
  return {ObjectId(id), Eigen::Vector3d::Zero(), kScale};
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

TEST(GiveCellsToNearestPlanes, GivesEachCellToASampleBesideIt) {
  Look look(2.0, {});
  std::mt19937 random(1);
  std::uniform_int_distribution<std::uint32_t> owner(1, 3);
  Association association;
  for (std::size_t index = 0; index < look.samples.size(); ++index) {
    association.owner.push_back(owner(random));
  }
  GiveCellsToNearestPlanes(look.samples, association, &look.cloud);
  const auto owner_at = [&](int column, int row) {
    return association.owner[look.samples.Index(std::min(column, look.samples.width() - 1),
                                                std::min(row, look.samples.height() - 1))];
  };
  std::size_t owned = 0;
  for (int row = 0; row < look.cloud.cells_high(); ++row) {
    for (int column = 0; column < look.cloud.cells_wide(); ++column) {
      const SurfaceCell& cell = look.cloud.At(column, row);
      if (!(cell.weight > 0.0F)) continue;
      ++owned;
      const std::array<std::uint32_t, 4> beside = {owner_at(column / 2, row / 2),
                                                   owner_at((column + 1) / 2, row / 2),
                                                   owner_at(column / 2, (row + 1) / 2),
                                                   owner_at((column + 1) / 2, (row + 1) / 2)};
      EXPECT_NE(std::find(beside.begin(), beside.end(), cell.owner), beside.end())
          << column << " " << row;
    }
  }
  EXPECT_GT(owned, 3 * look.samples.size());
}

TEST(GiveCellsToOwners, GivesCellsToTheOwnersOfTheirSamples) {
  Look look(2.0, {});
  Association association;
  association.owner.assign(look.samples.size(), Association::kNone);
  std::size_t owned_samples = 0;
  for (std::size_t index = 0; index < look.samples.size(); ++index) {
    const Eigen::Vector3f& position_world = look.samples[index].position_world;
    if (!look.samples[index].is_valid() || position_world.tail<2>().norm() > 0.5F) continue;
    association.owner[index] = 1;
    ++owned_samples;
  }
  ASSERT_GT(owned_samples, 500U);
  GiveCellsToOwners(look.samples, association, &look.cloud);
  std::size_t owned = 0;
  for (const SurfaceCell& cell : look.cloud.cells()) {
    if (!(cell.weight > 0.0F)) continue;
    EXPECT_EQ(cell.owner, 1U) << "what nobody owns weighs nothing";
    ++owned;
  }
  // One sample spans two cells in each direction.
  EXPECT_GT(owned, 7 * owned_samples / 2);
  EXPECT_LT(owned, 9 * owned_samples / 2);
}

}  // namespace
}  // namespace steadymap
