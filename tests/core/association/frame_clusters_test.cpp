#include "core/association/frame_clusters.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_map.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::SceneBody;
using ::steadymap::testing::StateOf;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::WallVolume;

constexpr VoxelScale kClusterScale;
constexpr std::uint16_t kClusterLabel = 4;

/// A wall of one square metre at 2 m, which faces the camera at the world origin.
class FrameClustersTest : public ::testing::Test {
 protected:
  FrameClustersTest() : wall_(ObjectId(1), Eigen::Vector3d::Zero(), kClusterScale) {
    StoreVolume(WallVolume(2.0, kClusterScale), &wall_);
    StateOf(&wall_).class_id = ClassId(kClusterLabel);
    StateOf(&wall_).status = ObjectStatus::kPresent;
  }

  /// Returns the number of samples that the wall owns in a frame of `bodies`.
  std::size_t CountClaimed(const std::vector<SceneBody>& bodies,
                           const ClusterParameters& parameters) {
    SemanticCloud cloud{MapConfig()};
    cloud.Compute(RenderScene(bodies, {}));
    SampleGrid samples;
    samples.Compute(cloud);
    FrameClusters clusters({}, parameters);
    clusters.Compute(samples, 0.0);
    const std::vector<ObjectInView> in_view = FindObjectsInView({&wall_}, cloud, samples, 5.0);
    Association association;
    AssociateSamples(samples, in_view, Background(), kClusterScale, clusters, &association);
    clusters.MatchOneToOne(in_view, &association);
    std::size_t count = 0;
    for (const std::uint32_t owner : association.owner) count += owner == 1 ? 1U : 0U;
    return count;
  }

  TrackedObject wall_;
};

/// Returns the visible part of a wall at 2 m, from `left_m` to `right_m`.
SceneBody SeenFrom(double left_m, double right_m, std::uint16_t label = kClusterLabel) {
  return Body(label, {2.0, left_m, -0.45}, {2.3, right_m, 0.45});
}

TEST_F(FrameClustersTest, BoundNothingUnlessAskedTo) {
  EXPECT_GT(CountClaimed({SeenFrom(-0.45, 0.45)}, {}), 100U);
  EXPECT_GT(CountClaimed({SeenFrom(-0.45, 3.0)}, {}), 100U);
}

TEST_F(FrameClustersTest, KeepAnObjectFromAClusterWhoseCentreLiesFarOff) {
  const ClusterParameters gate = {.center_distance_m = 0.2};
  EXPECT_EQ(CountClaimed({SeenFrom(-0.45, 0.45)}, gate), CountClaimed({SeenFrom(-0.45, 0.45)}, {}));
  // One or two samples at the borders belong to no cluster.
  EXPECT_LT(CountClaimed({SeenFrom(-0.45, 3.0)}, gate), 5U) << "centred further right";
}

TEST_F(FrameClustersTest, MatchAClusterThatLiesOnItsObject) {
  const ClusterParameters whole = {.is_one_to_one = true};
  EXPECT_GT(CountClaimed({SeenFrom(-0.45, 0.45)}, whole) + 10U,
            CountClaimed({SeenFrom(-0.45, 0.45)}, {}));
}

TEST_F(FrameClustersTest, LeaveOutAClusterOfWhichMuchIsUnknownOrOfAnotherClass) {
  const ClusterParameters whole = {.is_one_to_one = true};
  EXPECT_EQ(CountClaimed({SeenFrom(-0.45, 1.2)}, whole), 0U);
  EXPECT_EQ(CountClaimed({SeenFrom(-0.45, 0.45, 7)}, whole), 0U);
  EXPECT_GT(CountClaimed({SeenFrom(-0.45, 0.45, 7)}, {}), 100U);
}

TEST_F(FrameClustersTest, GiveAnObjectOneOfTwoClusters) {
  const std::vector<SceneBody> halves = {SeenFrom(-0.45, -0.15), SeenFrom(0.0, 0.45)};
  const std::size_t both = CountClaimed(halves, {});
  const std::size_t one = CountClaimed(halves, {.is_one_to_one = true});
  EXPECT_GT(one, 0U);
  EXPECT_LT(one, both);
}

}  // namespace
}  // namespace steadymap
