// Scenes with known ground truth: a wall at 2 m that a frame confirms, misses or does not observe.

#include "core/change/visibility.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/association/frame_clusters.h"
#include "core/change/belief_update.h"
#include "core/types/map_config.h"
#include "core/volume/background.h"
#include "tests/support/analytic_map.h"
#include "tests/support/analytic_scene.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kScale;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneLook;
using ::steadymap::testing::StateOf;
using ::steadymap::testing::StoreVolume;
using ::steadymap::testing::WallVolume;
using ::steadymap::testing::WithReach;

constexpr std::uint16_t kFarShelf = 6;

/// Returns a known wall of one square metre at `depth_m` along x, which faces the camera at the
/// world origin.
std::unique_ptr<TrackedObject> KnownWall(ObjectId id, double depth_m) {
  auto object = std::make_unique<TrackedObject>(id, Eigen::Vector3d::Zero(), kScale);
  StoreVolume(WallVolume(depth_m, kScale), object.get());
  StateOf(object.get()).class_id = ClassId(kWallClass);
  StateOf(object.get()).status = ObjectStatus::kPresent;
  return object;
}

/// Returns a wall that fills the image.
testing::SceneBody SeenWall(double depth_m, std::uint16_t label = kWallClass) {
  return Body(label, {depth_m, -4.0, -4.0}, {depth_m + 0.3, 4.0, 4.0});
}

/// Returns the verdict of a frame on the first of the objects. The camera looks along x.
ObjectVerdict JudgeFirst(const std::vector<TrackedObject*>& objects,
                         const Frame& frame,
                         const VisibilityParameters& parameters = {}) {
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  SampleGrid samples;
  samples.Compute(cloud);
  MinDepthGrid tiles;
  tiles.Compute(frame.depth);
  NoReturnLabels far_tiles{MapConfig()};
  far_tiles.Compute(frame);
  const std::vector<ObjectInView> in_view =
      FindObjectsInView(objects, cloud, samples, parameters.max_depth_m);
  Association association;
  AssociateSamples(samples, in_view, Background(), kScale, FrameClusters({}, {}), &association);
  const VisibilityTest test({cloud, samples, tiles, far_tiles}, in_view, association, parameters);
  return test.Judge(*objects.front());
}

ObjectVerdict JudgeWallAt2m(const Frame& frame) {
  const std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 2.0);
  return JudgeFirst({wall.get()}, frame);
}

/// Returns the number of evidence cells that the surface of the known wall intersects.
std::size_t CellsOfWallAt2m() {
  const std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 2.0);
  std::size_t cells = 0;
  for (const SurfaceLeaf& leaf : wall->surface().leaves()) {
    std::vector<bool> is_passed(kEvidenceCells, false);
    for (const SurfaceVoxel& point : leaf.points) is_passed[point.cell] = true;
    cells += static_cast<std::size_t>(std::count(is_passed.begin(), is_passed.end(), true));
  }
  return cells;
}

TEST(VisibilityTest, FindsAWallThatStands) {
  const ObjectVerdict verdict = JudgeWallAt2m(RenderScene({SeenWall(2.0)}, {}));
  EXPECT_EQ(verdict.present, CellsOfWallAt2m());
  EXPECT_EQ(verdict.seen_through, 0U);
  EXPECT_EQ(verdict.cells.size(), verdict.judged());
}

TEST(VisibilityTest, SeesThroughAWallThatIsGone) {
  const ObjectVerdict verdict = JudgeWallAt2m(RenderScene({SeenWall(2.6)}, {}));
  EXPECT_EQ(verdict.seen_through, CellsOfWallAt2m());
  EXPECT_EQ(verdict.present, 0U);
}

TEST(VisibilityTest, SeesThroughToSurfaceTooFarToBeFused) {
  ASSERT_LT(MapConfig().max_depth_m, 5.0);
  const ObjectVerdict verdict = JudgeWallAt2m(RenderScene({SeenWall(5.0)}, {}));
  EXPECT_EQ(verdict.seen_through, CellsOfWallAt2m());
}

TEST(VisibilityTest, SaysNothingOfAWallBehindANearerThing) {
  EXPECT_EQ(JudgeWallAt2m(RenderScene({SeenWall(1.0, kGoodsClass)}, {})).judged(), 0U);
  EXPECT_EQ(JudgeWallAt2m(RenderScene({SeenWall(1.0)}, {})).judged(), 0U);
}

TEST(VisibilityTest, SaysNothingWithoutReturns) {
  EXPECT_EQ(JudgeWallAt2m(RenderScene({}, {})).judged(), 0U);
  Frame invalid = RenderScene({SeenWall(2.0)}, {});
  invalid.depth.units = Image<std::uint16_t>(320, 240, kInvalidDepth);
  EXPECT_EQ(JudgeWallAt2m(invalid).judged(), 0U);
}

/// Returns a frame of a wall beyond the depth range, and a board at the lower image border with
/// returns from `board_m` to 30 cm further.
Frame LookPastTheReach(std::uint16_t label, double board_m) {
  const double far_end_m = board_m + 0.3;
  const Scene scene = {
      SeenWall(6.0, label),
      Body(kGoodsClass, {board_m, -4.0, -4.0}, {far_end_m, 4.0, -0.36 * far_end_m})};
  return WithReach(RenderScene(scene, {}), 5.0);
}

TEST(VisibilityTest, LooksPastAWallThatIsGoneToWhatTheLabelsTellOf) {
  const ObjectVerdict verdict = JudgeWallAt2m(LookPastTheReach(kFarShelf, 2.5));
  EXPECT_EQ(verdict.seen_through, CellsOfWallAt2m());
  EXPECT_EQ(verdict.judged(), verdict.seen_through);
}

TEST(VisibilityTest, SaysNothingOfAWallThatGivesNoDepthButItsLabel) {
  EXPECT_EQ(JudgeWallAt2m(LookPastTheReach(kWallClass, 2.5)).judged(), 0U);
}

TEST(VisibilityTest, SaysNothingOfAWallFurtherThanTheSensorMeasures) {
  EXPECT_EQ(JudgeWallAt2m(LookPastTheReach(kFarShelf, 1.5)).judged(), 0U)
      << "the frame has no depth beyond 1.5 m";
  const std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 2.0);
  const Frame frame = LookPastTheReach(kFarShelf, 2.5);
  VisibilityParameters parameters;
  for (const double sure_depth_m : {0.0, 1.8}) {
    parameters.sure_depth_m = sure_depth_m;
    EXPECT_EQ(JudgeFirst({wall.get()}, frame, parameters).judged(), 0U) << sure_depth_m;
  }
}

TEST(VisibilityTest, SaysNothingOfAWallInPlaceWithAnotherClass) {
  EXPECT_EQ(JudgeWallAt2m(RenderScene({SeenWall(2.0, kGoodsClass)}, {})).judged(), 0U);
}

// The side of a box that ends just in front of the wall is close to the wall edge, but has another
// normal.
TEST(VisibilityTest, TheSideOfAThingInFrontDoesNotShowAWall) {
  const Scene scene = {SeenWall(2.6), Body(kWallClass, {1.3, -4.0, -4.0}, {1.93, -0.46, 4.0})};
  const SceneLook look{.eye_world = {0.6, 0.9, 0.0}, .target_world = {2.0, -0.3, 0.0}};
  const ObjectVerdict verdict = JudgeWallAt2m(RenderScene(scene, look));
  EXPECT_GT(verdict.seen_through, CellsOfWallAt2m() / 2);
  EXPECT_EQ(verdict.present, 0U);
}

TEST(VisibilityTest, SaysNothingOfAWallSeenFromBehind) {
  const Frame frame = RenderScene({SeenWall(-3.0)},
                                  {.eye_world = {4.0, 0.0, 0.0}, .target_world = {0.0, 0.0, 0.0}});
  EXPECT_EQ(JudgeWallAt2m(frame).judged(), 0U);
}

TEST(VisibilityTest, SaysNothingBeyondItsReach) {
  const std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 5.5);
  const ObjectVerdict verdict = JudgeFirst({wall.get()}, RenderScene({SeenWall(5.9)}, {}));
  EXPECT_EQ(verdict.judged(), 0U);
}

TEST(VisibilityTest, JudgesOnlyThePartThatIsNotHidden) {
  const Scene half_hidden = {SeenWall(2.6), Body(kGoodsClass, {0.9, 0.0, -4.0}, {1.0, 4.0, 4.0})};
  const std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 2.0);
  const ObjectVerdict verdict = JudgeFirst({wall.get()}, RenderScene(half_hidden, {}));
  EXPECT_GT(verdict.seen_through, CellsOfWallAt2m() / 3);
  for (const CellVerdict& cell : verdict.cells) {
    EXPECT_EQ(cell.verdict, Verdict::kSeenThrough);
    const SurfaceLeaf& leaf = wall->surface().leaves()[cell.leaf];
    for (const SurfaceVoxel& point : leaf.points) {
      if (point.cell == cell.cell) {
        EXPECT_LT(point.position_object.y(), 0.15F);
      }
    }
  }
}

TEST(VisibilityTest, TakesSurfaceCloseBehindANewerOneOfItsClassAsReplaced) {
  const std::unique_ptr<TrackedObject> older = KnownWall(ObjectId(1), 2.0);
  const std::unique_ptr<TrackedObject> newer = KnownWall(ObjectId(2), 1.75);
  for (const SurfaceLeaf& leaf : older->surface().leaves()) {
    StateOf(older.get()).evidence.MutableLeaf(leaf.origin).confirmed = Timestamp::FromSeconds(90.0);
  }
  StateOf(newer.get()).in_place_since = Timestamp::FromSeconds(95.0);
  const Frame frame = RenderScene({SeenWall(1.75)}, {});
  const ObjectVerdict verdict = JudgeFirst({older.get(), newer.get()}, frame);
  EXPECT_GT(verdict.replaced, CellsOfWallAt2m() / 2);
  EXPECT_EQ(verdict.replaced, verdict.judged());

  StateOf(newer.get()).in_place_since = Timestamp::FromSeconds(91.0);
  EXPECT_EQ(JudgeFirst({older.get(), newer.get()}, frame).judged(), 0U)
      << "both were there at once";
  StateOf(newer.get()).in_place_since = Timestamp::FromSeconds(95.0);
  StateOf(newer.get()).class_id = ClassId(kGoodsClass);
  EXPECT_EQ(JudgeFirst({older.get(), newer.get()}, frame).judged(), 0U) << "of another class";
}

/// Returns the verdict on the known wall behind a newer box, if only the front of the box is
/// visible.
ObjectVerdict JudgeWallBehindBox(double front_m, double back_m) {
  const std::unique_ptr<TrackedObject> older = KnownWall(ObjectId(1), 2.0);
  for (const SurfaceLeaf& leaf : older->surface().leaves()) {
    StateOf(older.get()).evidence.MutableLeaf(leaf.origin).confirmed = Timestamp::FromSeconds(90.0);
  }
  const std::unique_ptr<TrackedObject> newer = KnownWall(ObjectId(2), front_m);
  const testing::Solid box = {
      Box(Eigen::Vector3d(front_m, -0.5, -0.5), Eigen::Vector3d(back_m, 0.5, 0.5))};
  StoreVolume(testing::MakeVolume(
                  [&](const Eigen::Vector3d& point) { return testing::DistanceFrom(box, point); },
                  Box(Eigen::Vector3d::Constant(-0.7), Eigen::Vector3d(back_m + 0.2, 0.7, 0.7)),
                  kScale,
                  [](const Eigen::Vector3d&) { return true; }),
              newer.get());
  StateOf(newer.get()).in_place_since = Timestamp::FromSeconds(95.0);
  return JudgeFirst({older.get(), newer.get()}, RenderScene({SeenWall(front_m)}, {}));
}

TEST(VisibilityTest, SaysNothingOfSurfaceBehindANewerThingThatEndsBeforeIt) {
  EXPECT_GT(JudgeWallBehindBox(1.6, 1.95).replaced, CellsOfWallAt2m() / 2);
  EXPECT_GT(JudgeWallBehindBox(1.6, 1.82).replaced, CellsOfWallAt2m() / 2) << "may be deeper";
  EXPECT_EQ(JudgeWallBehindBox(1.55, 1.76).judged(), 0U);
}

/// Returns the known wall, rotated about its centre by `yaw_rad` relative to the observed wall.
std::unique_ptr<TrackedObject> TurnedWall(double yaw_rad) {
  std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 2.0);
  StateOf(wall.get()).T_world_object = {
      {2.0 - 2.0 * std::cos(yaw_rad), -2.0 * std::sin(yaw_rad), 0.0}, yaw_rad};
  return wall;
}

TEST(VisibilityTest, TellsAWallThatWasTurned) {
  for (const double yaw_rad : {-0.2, 0.15}) {
    const ObjectVerdict verdict =
        JudgeFirst({TurnedWall(yaw_rad).get()}, RenderScene({SeenWall(2.0)}, {}));
    EXPECT_GT(verdict.turned, 50U);
    EXPECT_EQ(verdict.present, 0U);
    EXPECT_EQ(verdict.absent(), verdict.judged());
    EXPECT_FALSE(verdict.change_m.has_value());
  }
}

TEST(VisibilityTest, TakesALittleTurnForPoseError) {
  const ObjectVerdict verdict =
      JudgeFirst({TurnedWall(0.05).get()}, RenderScene({SeenWall(2.0)}, {}));
  EXPECT_GT(verdict.present, 50U);
  EXPECT_EQ(verdict.turned, 0U);
}

TEST(VisibilityTest, MeasuresHowFarAWallHasComeTowardsTheCamera) {
  const std::optional<double> none = JudgeWallAt2m(RenderScene({SeenWall(2.6)}, {})).change_m;
  EXPECT_FALSE(none.has_value()) << "nothing was found";
  const double scale = ChangeParameters().change_scale;
  for (const double nearer_m : {0.04, 0.0, -0.04}) {
    const ObjectVerdict verdict = JudgeWallAt2m(RenderScene({SeenWall(2.0 - nearer_m)}, {}));
    EXPECT_EQ(verdict.present, CellsOfWallAt2m());
    ASSERT_TRUE(verdict.change_m.has_value());
    EXPECT_NEAR(*verdict.change_m, scale * nearer_m, 0.006) << nearer_m;
  }
}

TEST(VisibilityTest, MeasuresChangeAlongTheViewOfASlantedWall) {
  const SceneLook look{.eye_world = {0.6, -1.4, 0.0}, .target_world = {2.0, 0.0, 0.0}};
  const double scale = ChangeParameters().change_scale;
  for (const double nearer_m : {0.04, 0.0, -0.04}) {
    const ObjectVerdict verdict = JudgeWallAt2m(RenderScene({SeenWall(2.0 - nearer_m)}, look));
    ASSERT_TRUE(verdict.change_m.has_value());
    EXPECT_NEAR(*verdict.change_m, scale * nearer_m * std::sqrt(2.0), 0.012) << nearer_m;
  }
}

/// Adds noise along z to the depth of a frame.
Frame WithDepthNoise(Frame frame, double noise_m, std::mt19937_64* random) {
  std::normal_distribution<double> noise(0.0, noise_m / frame.depth.metres_per_unit);
  for (std::size_t i = 0; i < frame.depth.units.size(); ++i) {
    std::uint16_t& units = frame.depth.units.data()[i];
    if (units != kNoDepth) units = static_cast<std::uint16_t>(units + std::lround(noise(*random)));
  }
  return frame;
}

/// Returns the mean change in the belief of the wall at 2 m after many noisy frames of a wall at
/// `seen_depth_m`.
double SettledChange(double seen_depth_m) {
  const std::unique_ptr<TrackedObject> wall = KnownWall(ObjectId(1), 2.0);
  const Frame frame = RenderScene({SeenWall(seen_depth_m)}, {});
  MapObject object;
  object.belief = InitialBelief(0.67);
  std::mt19937_64 random(5);
  for (int i = 0; i < 30; ++i) {
    const ObjectVerdict verdict = JudgeFirst({wall.get()}, WithDepthNoise(frame, 0.0176, &random));
    AddEvidence(verdict,
                wall->surface(),
                frame.capture_time,
                BeliefUpdateParameters().visit_gap_s,
                &object.evidence);
    UpdateBelief(
        StationarityPrior::kStationary, frame.capture_time, BeliefUpdateParameters(), &object);
  }
  EXPECT_GT(object.belief.stationarity(), 0.9);
  return object.belief.change_mean_m;
}

TEST(VisibilityTest, BeliefSettlesOnTheChangeOfAWallDespiteNoise) {
  const double scale = ChangeParameters().change_scale;
  EXPECT_NEAR(SettledChange(2.0), 0.0, 0.01);
  EXPECT_NEAR(SettledChange(1.96), scale * 0.04, 0.015);
  EXPECT_NEAR(SettledChange(2.04), scale * -0.04, 0.015);
}

}  // namespace
}  // namespace steadymap
