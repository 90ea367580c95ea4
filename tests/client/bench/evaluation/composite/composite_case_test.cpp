#include "client/bench/evaluation/composite/composite_case.h"

#include <gtest/gtest.h>

#include "client/bench/evaluation/composite/composite_score.h"
#include "client/bench/evaluation/composite/frame_composer.h"
#include "client/bench/simulator/scene/trajectory.h"

namespace steadymap {
namespace {

constexpr double kFloorM = 0.7;  // Its height.

/// Returns a room with a level floor of 3.6 m by 3.6 m, seen from two sides.
RecordedRoom FloorRoom() {
  RecordedRoom room;
  room.spacing_m = 0.03;
  for (int x = -60; x <= 60; ++x) {
    for (int y = -60; y <= 60; ++y) {
      const Eigen::Vector3d position(room.spacing_m * x, room.spacing_m * y, kFloorM);
      room.surface.push_back({position.cast<float>(), Eigen::Vector3f::UnitZ()});
    }
  }
  for (const double side : {-1.0, 1.0}) {
    Frame& view = room.views.emplace_back();
    view.camera = {640, 480, 420.0, 420.0, 320.0, 240.0};
    view.depth.units = Image<std::uint16_t>(640, 480, kNoDepth);
    view.T_world_camera = LookAt({2.0 * side, 0.0, kFloorM + 2.0}, {0.0, 0.0, kFloorM});
  }
  room.sensor = StructuredLightModel();
  return room;
}

TEST(MakeCompositeCase, PutsAThingForEachChangeOnTheFloor) {
  const CompositeCase things = MakeCompositeCase(FloorRoom(), 1);
  ASSERT_EQ(things.things.size(), 6U);
  EXPECT_EQ(things.before.objects().size(), 5U);
  EXPECT_EQ(things.after.objects().size(), 5U);
  for (const Scene* scene : {&things.before, &things.after}) {
    for (const SceneObject& thing : scene->objects()) {
      EXPECT_NEAR(BoxOf(thing).min().z(), kFloorM, 1e-6);
      for (const SceneObject& other : scene->objects()) {
        if (other.id == thing.id) continue;
        EXPECT_FALSE(BoxOf(thing).intersects(BoxOf(other)));
      }
    }
  }
}

TEST(MakeCompositeCase, ChangesThingsByTheirNames) {
  const CompositeCase things = MakeCompositeCase(FloorRoom(), 2);
  for (const PlacedThing& thing : things.things) {
    const SceneObject* before = things.before.Find(thing.id);
    const SceneObject* after = things.after.Find(thing.id);
    EXPECT_EQ(before == nullptr, thing.change == ThingChange::kAdded);
    EXPECT_EQ(after == nullptr, thing.change == ThingChange::kRemoved);
    if (before == nullptr || after == nullptr) continue;
    const double distance_m =
        (after->T_world_object.translation() - before->T_world_object.translation()).norm();
    const bool is_turned =
        !after->T_world_object.linear().isApprox(before->T_world_object.linear());
    EXPECT_EQ(is_turned, thing.change == ThingChange::kTurned);
    const bool is_near = thing.change == ThingChange::kMovedNear;
    const bool is_far = thing.change == ThingChange::kMovedFar;
    EXPECT_GE(distance_m, is_far ? 0.3 : is_near ? 0.1 : 0.0);
    EXPECT_LE(distance_m, is_far ? 1.0 : is_near ? 0.3 : 1e-9);
  }
}

TEST(MakeCompositeCase, DependsOnTheSeedAlone) {
  const RecordedRoom room = FloorRoom();
  const auto first_place = [&](std::uint64_t seed) {
    return MakeCompositeCase(room, seed).before.objects().front().T_world_object.matrix().eval();
  };
  EXPECT_EQ(first_place(5), first_place(5));
  EXPECT_NE(first_place(5), first_place(6));
}

TEST(MakeCompositeCase, FindsNoPlaceOnAWall) {
  RecordedRoom room = FloorRoom();
  for (SurfacePoint& point : room.surface) point.normal_world = Eigen::Vector3f::UnitX();
  EXPECT_TRUE(MakeCompositeCase(room, 1).things.empty());
}

/// A perfect map of a case, without background.
MethodOutcome PerfectOutcome(const CompositeTruth& truth) {
  MethodOutcome outcome;
  auto map = std::make_shared<MapSnapshot>(VoxelScale());
  const Timestamp end = truth.events.capture_times.back();
  for (const PlacedThing& thing : truth.things.things) {
    const SceneObject* before = truth.things.before.Find(thing.id);
    const SceneObject* after = truth.things.after.Find(thing.id);
    ObjectEvent event;
    event.type = before == nullptr  ? EventType::kCreated
                 : after == nullptr ? EventType::kRemoved
                                    : EventType::kMoved;
    event.class_id = truth.events.changes.front().class_id;
    event.time = end;
    event.center_world = BoxOf(after == nullptr ? *before : *after).center();
    if (before != nullptr) event.old_center_world = BoxOf(*before).center();
    if (thing.change != ThingChange::kNone) outcome.events.push_back(event);
    if (after == nullptr) continue;
    const Eigen::AlignedBox3d box_world = BoxOf(*after);
    auto object = std::make_shared<MapObject>();
    object->id = ObjectId(thing.id);
    object->status = ObjectStatus::kPresent;
    object->cuboid = {box_world.center(), box_world.sizes(), 0.0};
    map->objects.insert_or_assign(object->id, object);
    const std::vector<SurfacePoint> surface =
        SampleFacets(FacetsOf(after->shape, after->T_world_object), 0.02);
    outcome.surface.insert(outcome.surface.end(), surface.begin(), surface.end());
  }
  outcome.surface.insert(outcome.surface.end(), truth.room.begin(), truth.room.end());
  outcome.map = map;
  return outcome;
}

CompositeTruth TruthOf(const RecordedRoom& room) {
  CompositeTruth truth;
  truth.things = MakeCompositeCase(room, 4);
  truth.events = ListCompositeEvents(truth.things, ClassId(7));
  truth.events.capture_times = {Timestamp::FromSeconds(100.0), Timestamp::FromSeconds(200.0)};
  truth.events.first_frames = {0, 1, 2};
  truth.room = room.surface;
  return truth;
}

TEST(ScoreComposite, APerfectMapHasNoFaults) {
  const CompositeTruth truth = TruthOf(FloorRoom());
  const CompositeScore score = ScoreComposite(truth, PerfectOutcome(truth));
  EXPECT_EQ(score.events.f1(), 1.0);
  EXPECT_EQ(score.moves.part, 3U);
  EXPECT_EQ(score.moves.whole, 3U);
  EXPECT_EQ(score.cuboids.part, 5U);
  EXPECT_LT(score.ghosts.value(), 0.01);
  EXPECT_GT(score.ghosts.whole, 0U);
  EXPECT_EQ(score.kept.value(), 1.0);
  EXPECT_TRUE(score.faults.empty());
}

TEST(ScoreComposite, AMapThatNeverChangesHasGhosts) {
  const CompositeTruth truth = TruthOf(FloorRoom());
  MethodOutcome outcome = PerfectOutcome(truth);
  outcome.events.clear();
  for (const SceneObject& thing : truth.things.before.objects()) {
    const std::vector<SurfacePoint> surface =
        SampleFacets(FacetsOf(thing.shape, thing.T_world_object), 0.02);
    outcome.surface.insert(outcome.surface.end(), surface.begin(), surface.end());
  }
  const CompositeScore score = ScoreComposite(truth, outcome);
  EXPECT_EQ(score.events.found.part, 0U);
  EXPECT_EQ(score.events.found.whole, 8U);
  EXPECT_EQ(score.moves.part, 0U);
  EXPECT_EQ(score.ghosts.value(), 1.0);
  EXPECT_FALSE(score.faults.empty());
}

}  // namespace
}  // namespace steadymap
