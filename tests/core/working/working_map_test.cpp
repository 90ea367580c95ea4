#include "core/working/working_map.h"

#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_map.h"
#include "tests/support/analytic_solid.h"
#include "tests/support/object_edits.h"

namespace steadymap {
namespace {

using ObjectList = std::vector<TrackedObject*>;

/// Replaces the volume of the object by a cube with sides of 20 cm around a point of its frame.
void WriteCube(const Eigen::Vector3d& center_object, TrackedObject* object, WorkingMap* map) {
  const Box body(center_object.array() - 0.1, center_object.array() + 0.1);
  const Box around(center_object.array() - 0.3, center_object.array() + 0.3);
  const TsdfGrid cube = testing::MakeVolume(
      [&body](const Eigen::Vector3d& point) { return testing::DistanceFrom({body}, point); },
      around,
      VoxelScale(),
      [](const Eigen::Vector3d&) { return true; });
  ObjectEdit edit = map->Edit(object);
  testing::StoreVolume(cube, &edit);
}

/// Returns the expected result of `ObjectsNear`, by linear search.
ObjectList WalkNear(const Box& box_world, WorkingMap* map) {
  constexpr double kTouchM = 1e-3;
  const Box touching(box_world.min().array() - kTouchM, box_world.max().array() + kTouchM);
  ObjectList near;
  for (TrackedObject* object : map->AllObjects()) {
    const Box bounds_world = object->BoundsInWorld();
    if (!bounds_world.isEmpty() && bounds_world.intersects(touching)) near.push_back(object);
  }
  return near;
}

ObjectList WalkStanding(ObjectStatus standing, WorkingMap* map) {
  ObjectList objects;
  for (TrackedObject* object : map->AllObjects()) {
    if (object->state().status == standing) objects.push_back(object);
  }
  return objects;
}

/// Applies random operations of an update policy to a map.
class RandomPolicy {
 public:
  explicit RandomPolicy(unsigned seed) : random_(seed) {}

  void Step(WorkingMap* map) {
    if (map->objects().size() < 12) {
      map->AddObject(Position());
      return;
    }
    TrackedObject* object = Any(map);
    switch (std::uniform_int_distribution(0, 6)(random_)) {
      case 0:
        map->AddObject(Position());
        break;
      case 1:
        map->AddPart(*object);
        break;
      case 2:
        map->Delete(object);
        break;
      case 3:
        TakeVolume(*Any(map), object, map);
        break;
      case 4:
        Move(object, map);
        break;
      case 5:
        SetStatus(object, map);
        break;
      default:
        WriteCube(0.1 * Position(), object, map);
        break;
    }
  }

  Box AnyBox() {
    const Eigen::Vector3d center_world = Position();
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(Uniform(0.0, 6.0));
    return {center_world - reach, center_world + reach};
  }

  std::size_t Integer(std::size_t last) {
    return std::uniform_int_distribution<std::size_t>(0, last)(random_);
  }

 private:
  static void TakeVolume(const TrackedObject& other, TrackedObject* object, WorkingMap* map) {
    ObjectEdit edit = map->Edit(object);
    edit.TakeVolume(other);
  }

  void Move(TrackedObject* object, WorkingMap* map) {
    ObjectEdit edit = map->Edit(object);
    edit.state().T_world_object = {Position(), Uniform(-3.0, 3.0)};
  }

  void SetStatus(TrackedObject* object, WorkingMap* map) {
    if (object->is_deleted()) return;
    ObjectEdit edit = map->Edit(object);
    edit.state().status = static_cast<ObjectStatus>(Integer(2));
  }

  TrackedObject* Any(WorkingMap* map) {
    return map->AllObjects()[Integer(map->objects().size() - 1)];
  }

  double Uniform(double low, double high) {
    return std::uniform_real_distribution(low, high)(random_);
  }

  Eigen::Vector3d Position() {
    return {Uniform(-10.0, 10.0), Uniform(-10.0, 10.0), Uniform(-1.0, 1.0)};
  }

  std::mt19937 random_;
};

void ExpectFoundAsByWalk(const Box& box_world, WorkingMap* map) {
  ASSERT_EQ(map->ObjectsNear(box_world), WalkNear(box_world, map));
  ASSERT_EQ(map->TentativeObjects(), WalkStanding(ObjectStatus::kTentative, map));
  ASSERT_EQ(map->ArchivedObjects(), WalkStanding(ObjectStatus::kArchived, map));
}

TEST(WorkingMap, FindsByPlaceAndStandingWhatAWalkFindsWhateverHappened) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    RandomPolicy policy(seed);
    WorkingMap map((MapConfig()));
    std::size_t found = 0;
    for (std::uint64_t frame = 1; frame <= 60; ++frame) {
      map.BeginFrame(Revision(frame), Timestamp::FromSeconds(0.1 * static_cast<double>(frame)));
      for (std::size_t steps = policy.Integer(10); steps > 0; --steps) {
        policy.Step(&map);
        const Box box_world = policy.AnyBox();
        ASSERT_NO_FATAL_FAILURE(ExpectFoundAsByWalk(box_world, &map)) << seed << " " << frame;
        found += map.ObjectsNear(box_world).size();
      }
      map.EndFrame();
      ASSERT_NO_FATAL_FAILURE(ExpectFoundAsByWalk(policy.AnyBox(), &map)) << seed << " " << frame;
    }
    EXPECT_GT(found, 50U);
  }
}

TEST(WorkingMap, FindsAfterARestoreWhatItFoundBefore) {
  RandomPolicy policy(7);
  WorkingMap map((MapConfig()));
  map.BeginFrame(Revision(1), Timestamp::FromSeconds(1.0));
  for (int step = 0; step < 150; ++step) policy.Step(&map);
  map.EndFrame();
  WorkingMap restored((MapConfig()));
  restored.Restore(*map.Commit().snapshot);
  ASSERT_EQ(restored.objects().size(), map.objects().size());
  for (int box = 0; box < 20; ++box) {
    ASSERT_NO_FATAL_FAILURE(ExpectFoundAsByWalk(policy.AnyBox(), &restored));
  }
}

TEST(WorkingMap, SharesVolumesWithTheSnapshotItWasRestoredFromUntilItWritesThem) {
  WorkingMap map((MapConfig()));
  map.BeginFrame(Revision(1), Timestamp::FromSeconds(1.0));
  TrackedObject& made = map.AddObject(Eigen::Vector3d::Zero());
  WriteCube(Eigen::Vector3d::Zero(), &made, &map);
  const ObjectId id = made.id();
  map.EndFrame();
  const std::shared_ptr<const MapSnapshot> published = map.Commit().snapshot;
  const std::shared_ptr<const TsdfGrid> volume = published->objects.find(id)->second->volume;
  const std::size_t leaves = volume->leaf_count();

  WorkingMap restored((MapConfig()));
  restored.Restore(*published);
  TrackedObject& object = *restored.AllObjects().front();
  EXPECT_EQ(&object.volume(), volume.get()) << "memory for two";
  LeafVoxels leaf;
  leaf.observed.front() = 1;
  {
    ObjectEdit edit = restored.Edit(&object);
    edit.StoreLeaf({800, 0, 0}, leaf);
  }
  EXPECT_NE(&object.volume(), volume.get());
  EXPECT_EQ(object.volume().leaf_count(), leaves + 1);
  EXPECT_EQ(volume->leaf_count(), leaves);
}

TEST(WorkingMap, KeepsTheRobotThatItStoresThoughAllOthersAreNewer) {
  WorkingMap map((MapConfig()));
  constexpr int kRobots = 1500;
  for (int i = 0; i < kRobots; ++i) {
    const SensorName sensor{"robot-" + std::to_string(i), SensorName::kDefaultSensor};
    RobotState state;
    state.last_capture_time = Timestamp::FromSeconds(kRobots - i);
    map.StoreRobot(sensor, state);
    ASSERT_NE(map.FindRobot(sensor), nullptr) << i;
  }
  EXPECT_LT(map.Commit().snapshot->robots.size(), kRobots);
}

TEST(WorkingMap, FindsNothingInAnEmptyBoxNorAnObjectWithoutSurface) {
  WorkingMap map((MapConfig()));
  map.BeginFrame(Revision(1), Timestamp::FromSeconds(1.0));
  const Box around(Eigen::Vector3d::Constant(-1.0), Eigen::Vector3d::Constant(1.0));
  TrackedObject& object = map.AddObject(Eigen::Vector3d::Zero());
  EXPECT_TRUE(map.ObjectsNear(around).empty());
  WriteCube(Eigen::Vector3d::Zero(), &object, &map);
  EXPECT_EQ(map.ObjectsNear(around), ObjectList{&object});
  EXPECT_TRUE(map.ObjectsNear(Box()).empty());
}

}  // namespace
}  // namespace steadymap
