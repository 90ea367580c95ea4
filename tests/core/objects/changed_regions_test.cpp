// A box on a slab, without labels: one of both sessions lacks the box.

#include "core/objects/changed_regions.h"

#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "core/types/map_config.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::MakeVolumeAt;
using ::steadymap::testing::Solid;
using ::steadymap::testing::StoreVolume;

const Box kSlab(Eigen::Vector3d(-1.0, -1.0, -0.4), Eigen::Vector3d(1.0, 1.0, 0.0));
const Box kBox(Eigen::Vector3d(-0.2, -0.2, -0.2), Eigen::Vector3d(0.2, 0.2, 0.4));

class ChangedRegionsTest : public ::testing::Test {
 protected:
  ChangedRegionsTest() { map_.BeginFrame(Revision(1), Timestamp::FromSeconds(100.0)); }

  /// Adds what was observed of bodies, up to `end_x_m`.
  TrackedObject* Add(const Solid& bodies, double end_x_m = 2.0) {
    return AddSeen(bodies, [=](const Eigen::Vector3d& point) { return point.x() < end_x_m; });
  }

  /// Adds what `is_observed` of bodies.
  TrackedObject* AddSeen(const Solid& bodies,
                         const std::function<bool(const Eigen::Vector3d&)>& is_observed) {
    TrackedObject& object = map_.AddObject(Eigen::Vector3d::Zero());
    const Box bounds(Eigen::Vector3d(-1.2, -1.2, -0.15), Eigen::Vector3d(1.2, 1.2, 0.6));
    ObjectEdit edit = map_.Edit(&object);
    StoreVolume(MakeVolumeAt(object.state().T_world_object.position_world,
                             bodies,
                             bounds,
                             map_.scale(),
                             [&](const Eigen::Vector3d& point) {
                               return point.z() > -0.12 && is_observed(point);
                             }),
                &edit);
    return &object;
  }

  /// Gives the evidence cells of an object at points for which `is_gone` returns true the score of
  /// absence, and all others the score of presence, or none at heights up to `unseen_m`.
  template <typename IsGone>
  void Look(TrackedObject* object, double unseen_m, const IsGone& is_gone) {
    const Eigen::Isometry3d T_world_object = object->state().T_world_object.ToIsometry();
    ObjectEdit edit = map_.Edit(object);
    for (const SurfaceLeaf& leaf : object->surface().leaves()) {
      LeafEvidence& evidence = edit.state().evidence.MutableLeaf(leaf.origin);
      for (const SurfaceVoxel& point : leaf.points) {
        const Eigen::Vector3d world = T_world_object * point.position_object.cast<double>();
        const bool is_side = world.z() > 0.03;
        if (is_side && world.z() <= unseen_m) continue;
        evidence.score[point.cell()] = is_gone(world) ? -2 : 2;
      }
    }
  }

  SessionPartParameters parameters_;
  WorkingMap map_{MapConfig()};
};

TEST_F(ChangedRegionsTest, ABoxThatLeftIsARegionDownToItsFoot) {
  TrackedObject* object = Add({kSlab, kBox});
  // Its lower half was not looked at; the cells at its foot show the slab, too.
  Look(object, 0.2, [](const Eigen::Vector3d& point) { return point.z() > 0.2; });
  const std::vector<TrackedObject*> regions = SeparateGoneRegions(parameters_, object, &map_);
  ASSERT_EQ(regions.size(), 1U);
  const Box gone = regions.front()->BoundsInWorld();
  EXPECT_NEAR(gone.max().z(), 0.4, 0.06);
  EXPECT_LT(gone.min().z(), 0.17);
  EXPECT_LT(object->BoundsInWorld().max().z(), 0.17);
}

TEST_F(ChangedRegionsTest, NothingIsGoneOfWhatWasFound) {
  TrackedObject* object = Add({kSlab, kBox});
  Look(object, 0.0, [](const Eigen::Vector3d&) { return false; });
  EXPECT_TRUE(SeparateGoneRegions(parameters_, object, &map_).empty());
}

TEST_F(ChangedRegionsTest, AFewGoneCellsAreNoRegion) {
  TrackedObject* object = Add({kSlab, kBox});
  Look(object, 0.0, [](const Eigen::Vector3d& point) {
    return (point - Eigen::Vector3d(0.2, 0.2, 0.4)).norm() < 0.04;
  });
  EXPECT_TRUE(SeparateGoneRegions(parameters_, object, &map_).empty());
}

TEST_F(ChangedRegionsTest, ABoxThatCameIsARegion) {
  const TrackedObject* known = Add({kSlab});
  TrackedObject* seen = Add({kSlab, kBox});
  for (int x = -9; x <= 10; ++x) {
    for (int y = -9; y <= 10; ++y) {
      const Eigen::Vector3d low(0.1 * x - 0.05, 0.1 * y - 0.05, 0.15);
      map_.MarkFree(low, {low.x(), low.y(), 0.55}, map_.now());
    }
  }
  const std::vector<TrackedObject*> regions = SeparateNewRegions(parameters_, *known, seen, &map_);
  ASSERT_EQ(regions.size(), 1U);
  const Box came = regions.front()->BoundsInWorld();
  EXPECT_NEAR(came.max().z(), 0.4, 0.06);
  EXPECT_NEAR(came.min().x(), -0.2, 0.12);
  EXPECT_NEAR(came.max().x(), 0.2, 0.12);
  EXPECT_LT(seen->BoundsInWorld().max().z(), 0.12);
}

TEST_F(ChangedRegionsTest, ABoxHigherThanAVoxelIsNewWhereASlabWasSeen) {
  const TrackedObject* without_box = Add({kSlab});
  const Box low(Eigen::Vector3d(-0.15, -0.15, -0.2), Eigen::Vector3d(0.15, 0.15, 0.07));
  const TrackedObject* with_box = Add({kSlab, low});
  const TrackedObject* seen = AddSeen({kSlab, low}, [](const Eigen::Vector3d& point) {
    return point.z() > 0.02 && point.head<2>().lpNorm<Eigen::Infinity>() < 0.22;
  });
  EXPECT_GT(NewShareOf(parameters_, *without_box, *seen, map_), 0.5);
  EXPECT_EQ(NewShareOf(parameters_, *with_box, *seen, map_), 0.0);
}

TEST_F(ChangedRegionsTest, SurfaceInSpaceThatWasNotSeenIsNotNew) {
  const TrackedObject* known = Add({kSlab}, -0.5);
  TrackedObject* seen = Add({kSlab, kBox});
  EXPECT_TRUE(SeparateNewRegions(parameters_, *known, seen, &map_).empty());
}

TEST_F(ChangedRegionsTest, AFaceInOneLayerOfVoxelsIsNotNew) {
  // Seen at flat angles, the face at x = 0.2 m is a layer of voxels, here with a normal that noise
  // has turned round.
  const TrackedObject* known = Add({kBox}, 0.22);
  const Box turned(Eigen::Vector3d(0.2, -0.2, -0.2), Eigen::Vector3d(0.6, 0.2, 0.4));
  TrackedObject* seen = AddSeen({turned}, [](const Eigen::Vector3d& point) {
    return point.x() < 0.28 && std::abs(point.y()) < 0.18 && point.z() < 0.38;
  });
  for (int y = -2; y <= 2; ++y) {
    for (int x = 2; x <= 4; ++x) {
      map_.MarkFree({0.1 * x + 0.05, 0.1 * y + 0.05, 0.05},
                    {0.1 * x + 0.05, 0.1 * y + 0.05, 0.55},
                    map_.now());
    }
  }
  EXPECT_TRUE(SeparateNewRegions(parameters_, *known, seen, &map_).empty());
}

TEST_F(ChangedRegionsTest, TheSameSurfaceIsNotNew) {
  const TrackedObject* known = Add({kSlab, kBox});
  EXPECT_TRUE(SeparateNewRegions(parameters_, *known, Add({kSlab, kBox}), &map_).empty());
}

}  // namespace
}  // namespace steadymap
