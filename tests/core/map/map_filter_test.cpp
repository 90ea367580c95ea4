#include "core/map/map_filter.h"

#include <gtest/gtest.h>

namespace steadymap {
namespace {

/// Returns an object of class 7 with a cuboid of 0.5 m around (x, 0, 0).
ObjectState ObjectAt(std::uint64_t id, double x_m) {
  ObjectState object;
  object.id = ObjectId(id);
  object.status = ObjectStatus::kPresent;
  object.class_id = ClassId(7);
  object.cuboid = {{x_m, 0.0, 0.0}, {0.5, 0.5, 0.5}, 0.0};
  return object;
}

ObjectEvent EventAt(std::uint64_t id, double x_m) {
  ObjectEvent event;
  event.object = ObjectId(id);
  event.class_id = ClassId(7);
  event.center_world = {x_m, 0.0, 0.0};
  return event;
}

const Box kNearOrigin(Eigen::Vector3d(-1.0, -1.0, -1.0), Eigen::Vector3d(1.0, 1.0, 1.0));

TEST(MapFilter, WithoutConditionsShowsWhatTheMapShows) {
  const MapFilter filter;
  ObjectState object = ObjectAt(1, 100.0);
  EXPECT_TRUE(filter.Shows(object));
  object.status = ObjectStatus::kTentative;
  EXPECT_FALSE(filter.Shows(object));
  object.status = ObjectStatus::kArchived;
  EXPECT_FALSE(filter.Shows(object));
  EXPECT_TRUE(filter.ShowsBackgroundLeaf({800, -800, 0}, VoxelScale()));
  EXPECT_TRUE(filter.Shows(EventAt(1, 100.0)));
}

TEST(MapFilter, ShowsArchivedObjectsWhereAskedToAndTentativeOnesNever) {
  MapFilter filter;
  filter.archived = true;
  ObjectState object = ObjectAt(1, 0.0);
  object.status = ObjectStatus::kArchived;
  EXPECT_TRUE(filter.Shows(object));
  object.status = ObjectStatus::kTentative;
  EXPECT_FALSE(filter.Shows(object));
}

TEST(MapFilter, AnObjectThatTouchesABoxPassesWhole) {
  MapFilter filter;
  filter.boxes_world = {kNearOrigin};
  EXPECT_TRUE(filter.Shows(ObjectAt(1, 0.0)));
  EXPECT_TRUE(filter.Shows(ObjectAt(1, 1.2)));
  EXPECT_TRUE(filter.Shows(ObjectAt(1, 1.25)));
  EXPECT_FALSE(filter.Shows(ObjectAt(1, 1.3)));
  filter.boxes_world.push_back(kNearOrigin.translated(Eigen::Vector3d(5.0, 0.0, 0.0)));
  EXPECT_TRUE(filter.Shows(ObjectAt(1, 5.0)));
}

TEST(MapFilter, OfTheBackgroundTheLeavesThatTouchABoxPass) {
  MapFilter filter;
  filter.boxes_world = {kNearOrigin};
  const VoxelScale scale{0.05, 0.15};
  EXPECT_TRUE(filter.ShowsBackgroundLeaf({0, 0, 0}, scale));
  EXPECT_TRUE(filter.ShowsBackgroundLeaf({16, 0, 0}, scale));
  EXPECT_FALSE(filter.ShowsBackgroundLeaf({24, 0, 0}, scale));
}

TEST(MapFilter, TheBackgroundIsObjectZeroOfClassZero) {
  MapFilter filter;
  filter.classes = {ClassId(7)};
  EXPECT_FALSE(filter.ShowsBackground());
  EXPECT_TRUE(filter.Shows(ObjectAt(1, 0.0)));
  filter.classes = {ClassId(0)};
  EXPECT_TRUE(filter.ShowsBackground());
  EXPECT_FALSE(filter.Shows(ObjectAt(1, 0.0)));
  filter.classes.clear();
  filter.objects = {ObjectId(1)};
  EXPECT_FALSE(filter.ShowsBackground());
  EXPECT_TRUE(filter.Shows(ObjectAt(1, 0.0)));
  EXPECT_FALSE(filter.Shows(ObjectAt(2, 0.0)));
  filter.objects = {kBackgroundId};
  EXPECT_TRUE(filter.ShowsBackground());
}

TEST(MapFilter, AMovePassesByWhereItWentAndByWhereItCameFrom) {
  MapFilter filter;
  filter.boxes_world = {kNearOrigin};
  ObjectEvent event = EventAt(1, 9.0);
  EXPECT_FALSE(filter.Shows(event));
  event.old_center_world = Eigen::Vector3d(0.5, 0.0, 0.0);
  EXPECT_TRUE(filter.Shows(event));
  EXPECT_TRUE(filter.Shows(EventAt(1, 0.5)));
}

TEST(MapFilter, AMergePassesByEitherObject) {
  MapFilter filter;
  filter.objects = {ObjectId(2)};
  ObjectEvent event = EventAt(1, 0.0);
  EXPECT_FALSE(filter.Shows(event));
  event.related = ObjectId(2);
  EXPECT_TRUE(filter.Shows(event));
  filter.objects = {kBackgroundId};
  event.related = kBackgroundId;
  EXPECT_FALSE(filter.Shows(event));
}

TEST(MapFilter, EventsOfRobotsPassWhereNothingIsAskedOfObjects) {
  ObjectEvent event;
  event.type = EventType::kRobotLost;
  event.source = {"r1", "camera"};
  MapFilter filter;
  EXPECT_TRUE(filter.Shows(event));
  filter.boxes_world = {kNearOrigin};
  EXPECT_FALSE(filter.Shows(event));
  filter.boxes_world.clear();
  filter.classes = {ClassId(0)};
  EXPECT_FALSE(filter.Shows(event));
  filter.classes.clear();
  filter.objects = {kBackgroundId};
  EXPECT_FALSE(filter.Shows(event));
}

}  // namespace
}  // namespace steadymap
