#include "client/bench/simulator/routes/torwic_hall.h"

#include <cmath>
#include <map>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace steadymap {
namespace {

Scene Hall(std::string_view configuration) {
  absl::StatusOr<Scene> scene = MakeTorwicHall(configuration);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

std::vector<std::uint16_t> IdsOf(const Scene& scene,
                                 const std::function<bool(const SceneObject&)>& predicate) {
  std::vector<std::uint16_t> ids;
  for (const SceneObject& object : scene.objects()) {
    if (predicate(object)) ids.push_back(object.id);
  }
  return ids;
}

auto Named(std::string_view prefix) {
  return [prefix](const SceneObject& object) { return object.name.starts_with(prefix); };
}

bool IsStack(const SceneObject& object) {
  return Named("outer-")(object) || Named("inner-")(object);
}

// Returns the displacement of an object from the baseline to a configuration.
Eigen::Vector3d MovementOf(const Scene& before, const Scene& after, std::uint16_t id) {
  return after.Find(id)->T_world_object.translation() -
         before.Find(id)->T_world_object.translation();
}

void ExpectShift(std::string_view configuration,
                 const std::function<bool(const SceneObject&)>& predicate,
                 const Eigen::Vector3d& shift_m) {
  const Scene before = Hall("baseline");
  const Scene after = Hall(configuration);
  const SceneChange change = CompareScenes(before, after);
  EXPECT_EQ(change.moved, IdsOf(before, predicate)) << configuration;
  EXPECT_TRUE(change.created.empty() && change.removed.empty()) << configuration;
  for (const std::uint16_t id : change.moved) {
    EXPECT_NEAR((MovementOf(before, after, id) - shift_m).norm(), 0, 1e-12) << configuration;
  }
}

void ExpectRemoval(std::string_view configuration,
                   const std::function<bool(const SceneObject&)>& predicate) {
  const Scene before = Hall("baseline");
  const SceneChange change = CompareScenes(before, Hall(configuration));
  EXPECT_EQ(change.removed, IdsOf(before, predicate)) << configuration;
  EXPECT_TRUE(change.created.empty() && change.moved.empty()) << configuration;
}

TEST(TorwicHall, BaselineHasItsRingsFencesAndTag) {
  const Scene hall = Hall("baseline");
  EXPECT_EQ(IdsOf(hall, Named("outer-")).size(), 24U);
  EXPECT_EQ(IdsOf(hall, Named("outer-top-")).size(), 6U);
  EXPECT_EQ(IdsOf(hall, Named("inner-")).size(), 20U);
  EXPECT_EQ(IdsOf(hall, Named("fence-")).size(), 8U);
  EXPECT_EQ(IdsOf(hall, Named("tag-")).size(), 2U);
  EXPECT_EQ(hall.objects().size(), 55U);
  for (const SceneObject& object : hall.objects()) {
    if (IsStack(object)) {
      EXPECT_EQ(object.semantic_class, SceneClass::kGoods);
      EXPECT_EQ(std::get<BoxShape>(object.shape).size_m.z(), 2.0);
    }
    if (Named("fence-")(object)) {
      const Eigen::Vector3d size_m = std::get<BoxShape>(object.shape).size_m;
      EXPECT_EQ(object.semantic_class, SceneClass::kWall);
      EXPECT_EQ(size_m.z(), 3.0);
      EXPECT_NEAR(size_m.y(), 0.1, 1e-12);
      EXPECT_GE(size_m.x(), 0.9);
      EXPECT_LE(size_m.x(), 1.9);
    }
  }
}

TEST(TorwicHall, PairsOfTheTopRowStandWhereTheDrawingPutsThem) {
  const Scene hall = Hall("baseline");
  for (const auto& [group, x_m] : std::map<std::string, double>{
           {"outer-top-1", -1.4}, {"outer-top-2", 0}, {"outer-top-3", 1.4}}) {
    double low_m = 10;
    double high_m = -10;
    for (const SceneObject& object : hall.objects()) {
      if (object.group != group) continue;
      EXPECT_NEAR(object.T_world_object.translation().y(), 3.5, 1e-12);
      low_m = std::min(low_m, object.T_world_object.translation().x() - 0.235);
      high_m = std::max(high_m, object.T_world_object.translation().x() + 0.235);
    }
    EXPECT_NEAR(high_m - low_m, 0.94, 1e-12);
    EXPECT_NEAR((high_m + low_m) / 2, x_m, 1e-12);
  }
}

TEST(TorwicHall, ScenariosOneShiftWhatTheySay) {
  ExpectShift("1-1", Named("outer-top-"), {0, 0.5, 0});
  ExpectShift("1-2", Named("outer-top-"), {0, 1.0, 0});
  ExpectShift("1-3", Named("outer-top-"), {0.5, 0, 0});
  ExpectShift("1-4", IsStack, {0.25, 0.25, 0});
}

TEST(TorwicHall, Scenario15TurnsAllStacksAboutTheCentre) {
  const Scene before = Hall("baseline");
  const Scene after = Hall("1-5");
  const SceneChange change = CompareScenes(before, after);
  EXPECT_EQ(change.moved, IdsOf(before, IsStack));
  for (const std::uint16_t id : change.moved) {
    const Eigen::Isometry3d turn =
        after.Find(id)->T_world_object * before.Find(id)->T_world_object.inverse();
    // A rotation about the origin.
    EXPECT_NEAR(turn.translation().norm(), 0, 1e-9);
    EXPECT_GE(YawOf(turn), 10 * M_PI / 180);
    EXPECT_LE(YawOf(turn), 15 * M_PI / 180);
  }
}

TEST(TorwicHall, Scenarios16And17ShrinkTheRings) {
  const Scene before = Hall("baseline");
  for (const char* configuration : {"1-6", "1-7"}) {
    const Scene after = Hall(configuration);
    const SceneChange change = CompareScenes(before, after);
    const bool both = std::string(configuration) == "1-7";
    EXPECT_EQ(change.moved, both ? IdsOf(before, IsStack) : IdsOf(before, Named("inner-")));
    for (const std::uint16_t id : change.moved) {
      EXPECT_LT(after.Find(id)->T_world_object.translation().head<2>().norm(),
                before.Find(id)->T_world_object.translation().head<2>().norm() - 0.1);
    }
  }
}

TEST(TorwicHall, Scenario18AlternatesAndScenario19Steps) {
  const Scene before = Hall("baseline");
  const Scene alternating = Hall("1-8");
  EXPECT_EQ(CompareScenes(before, alternating).moved, IdsOf(before, IsStack));
  const Scene stepping = Hall("1-9");
  EXPECT_EQ(CompareScenes(before, stepping).moved, IdsOf(before, Named("outer-")));
  double sign = 1;
  double step_m = 0;
  for (const char* name : {"outer-top-1-a", "outer-top-2-a", "outer-top-3-a"}) {
    const std::uint16_t id = IdsOf(before, Named(name)).at(0);
    EXPECT_NEAR(MovementOf(before, alternating, id).y(), sign * 0.3, 1e-12);
    sign = -sign;
    EXPECT_GT(MovementOf(before, stepping, id).y(), step_m);
    step_m = MovementOf(before, stepping, id).y();
  }
}

TEST(TorwicHall, ScenariosTwoRemoveWhatTheySay) {
  ExpectRemoval("2-1", Named("outer-top-"));
  ExpectRemoval("2-3", IsStack);
  ExpectRemoval("2-4", Named("fence-"));
  const Scene before = Hall("baseline");
  const SceneChange change = CompareScenes(before, Hall("2-2"));
  EXPECT_EQ(change.removed.size(), 12U);
  for (const std::uint16_t id : change.removed) {
    EXPECT_TRUE(before.Find(id)->name.starts_with("inner-"));
    const Eigen::Vector3d place = before.Find(id)->T_world_object.translation();
    EXPECT_GT(std::min(std::abs(place.x()), std::abs(place.y())), 1.0);
  }
  EXPECT_EQ(change.created.size(), 4U);
  EXPECT_TRUE(change.moved.empty());
}

TEST(TorwicHall, ScenariosThreeMoveRowsAndFences) {
  ExpectShift("3-1",
              [](const SceneObject& object) {
                return Named("outer-top-")(object) || Named("fence-top-")(object);
              },
              {0, 0.5, 0});
  const Scene before = Hall("baseline");
  EXPECT_EQ(CompareScenes(before, Hall("3-2")).moved, IdsOf(before, [](const SceneObject& object) {
              return Named("outer-")(object) && !Named("outer-bottom-")(object);
            }));
  EXPECT_EQ(CompareScenes(before, Hall("3-3")).moved, IdsOf(before, Named("fence-")));
}

TEST(TorwicHall, Scenario41CoversEachFenceAndAddsAPairOfWalls) {
  const Scene before = Hall("baseline");
  const Scene after = Hall("4-1");
  const SceneChange change = CompareScenes(before, after);
  EXPECT_TRUE(change.moved.empty() && change.removed.empty());
  std::map<SceneClass, int> counts;
  for (const std::uint16_t id : change.created) ++counts[after.Find(id)->semantic_class];
  EXPECT_EQ(counts[SceneClass::kGoods], 12);
  EXPECT_EQ(counts[SceneClass::kWall], 2);
}

TEST(TorwicHall, AnIdMeansTheSameThingInAllConfigurations) {
  std::map<std::uint16_t, std::string> names;
  for (const std::string& configuration : TorwicConfigurations()) {
    const Scene hall = Hall(configuration);
    for (const SceneObject& object : hall.objects()) {
      EXPECT_EQ(names.emplace(object.id, object.name).first->second, object.name);
    }
  }
}

// Returns the interval that a box on the ground covers along a direction.
std::pair<double, double> Extent(const SceneObject& object, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d half_m = std::get<BoxShape>(object.shape).size_m / 2;
  const double center = object.T_world_object.translation().dot(direction);
  const double reach =
      (object.T_world_object.linear().transpose() * direction).cwiseAbs().dot(half_m);
  return {center - reach, center + reach};
}

bool Overlap(const SceneObject& a, const SceneObject& b) {
  constexpr double kTouchingM = 1e-6;
  for (const SceneObject* object : {&a, &b}) {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d direction = object->T_world_object.linear().col(axis);
      const auto [a_low, a_high] = Extent(a, direction);
      const auto [b_low, b_high] = Extent(b, direction);
      if (a_high <= b_low + kTouchingM || b_high <= a_low + kTouchingM) return false;
    }
  }
  return true;
}

TEST(TorwicHall, NothingStandsInsideAnythingElse) {
  for (const std::string& configuration : TorwicConfigurations()) {
    const Scene hall = Hall(configuration);
    for (const SceneObject& a : hall.objects()) {
      for (const SceneObject& b : hall.objects()) {
        if (a.id >= b.id || a.name == "floor" || b.name == "floor") continue;
        EXPECT_FALSE(Overlap(a, b)) << configuration << ": " << a.name << " and " << b.name;
      }
    }
  }
}

TEST(TorwicHall, TheRobotsWayIsFreeInAllConfigurations) {
  const Trajectory drive = DriveTorwicLoop();
  for (const std::string& configuration : TorwicConfigurations()) {
    const Scene hall = Hall(configuration);
    for (const SceneObject& object : hall.objects()) {
      if (object.name == "floor") continue;
      const Eigen::Vector3d half_m = std::get<BoxShape>(object.shape).size_m / 2;
      for (int i = 0; i * 0.2 < drive.duration_s; ++i) {
        const double time_s = i * 0.2;
        const Eigen::Vector3d camera =
            object.T_world_object.inverse() * drive.T_world_camera(time_s).translation();
        const double distance_m = (camera.cwiseAbs() - half_m).cwiseMax(0).norm();
        ASSERT_GT(distance_m, 0.1) << configuration << ": " << object.name << " at " << time_s;
      }
    }
  }
}

TEST(TorwicHall, RefusesAnUnknownConfiguration) {
  EXPECT_FALSE(MakeTorwicHall("5-1").ok());
  EXPECT_FALSE(MakeTorwicHall("").ok());
  EXPECT_FALSE(MakeTorwicHall("2-").ok());
}

TEST(TorwicLoop, IsARoundedFiveMetreSquare) {
  const GroundPath loop = TorwicLoop();
  EXPECT_NEAR(loop.length_m(), 4 * (5 - 2 * 0.8) + 2 * M_PI * 0.8, 1e-9);
  double largest = 0.0;
  for (int i = 0; i * 0.05 < loop.length_m(); ++i) {
    const double s_m = i * 0.05;
    const Eigen::Isometry3d pose = loop.PoseAt(s_m);
    largest = std::max(largest, pose.translation().cwiseAbs().maxCoeff());
    // It turns left round the centre, without jumps.
    const Eigen::Vector3d to_next = loop.PoseAt(s_m + 0.01).translation() - pose.translation();
    EXPECT_NEAR(to_next.norm(), 0.01, 1e-5);
    EXPECT_NEAR(to_next.normalized().dot(pose.linear().col(0)), 1, 1e-4);
    EXPECT_GT(pose.translation().cross(to_next).z(), 0);
  }
  EXPECT_NEAR(largest, 2.5, 1e-9);
  EXPECT_TRUE(loop.PoseAt(loop.length_m()).isApprox(loop.PoseAt(0), 1e-9));
}

TEST(DriveTorwicLoop, CarriesTheCameraHalfAMetreUpLookingAheadAndSlightlyUp) {
  const Trajectory drive = DriveTorwicLoop();
  const double frame_count = drive.duration_s / drive.frame_period_s;
  EXPECT_GT(frame_count, 300);
  EXPECT_LT(frame_count, 400);
  const GroundPath loop = TorwicLoop();
  for (int i = 0; i * 0.7 < drive.duration_s; ++i) {
    const double time_s = i * 0.7;
    const Eigen::Isometry3d T_world_camera = drive.T_world_camera(time_s);
    EXPECT_NEAR(T_world_camera.translation().z(), 0.5, 0.02);
    const Eigen::Vector3d ahead = loop.PoseAt(0.5 * time_s).linear().col(0);
    const Eigen::Vector3d sight = T_world_camera.linear().col(2);
    EXPECT_GT(sight.dot(ahead), 0.94);
    EXPECT_GT(sight.z(), 0.1);
    EXPECT_LT(sight.z(), 0.35);
    EXPECT_LT(T_world_camera.linear().col(1).z(), -0.9);  // Upright.
  }
}

}  // namespace
}  // namespace steadymap
