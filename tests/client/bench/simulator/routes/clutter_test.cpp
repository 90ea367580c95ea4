#include "client/bench/simulator/routes/clutter.h"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>

#include "client/bench/simulator/simulation.h"

namespace steadymap {
namespace {

bool IsLoose(const SceneObject& object) {
  return object.instance != 0 && !object.name.starts_with("table") &&
         !object.name.starts_with("shelf");
}

TEST(MakeClutterRoute, IsAnotherRoomForAnotherSeedAndTheSameForTheSame) {
  const Route route = MakeClutterRoute(4);
  const SceneChange same =
      CompareScenes(route.sequences[1].scene, MakeClutterRoute(4).sequences[1].scene);
  EXPECT_TRUE(same.created.empty() && same.removed.empty() && same.moved.empty());
  const SceneChange other =
      CompareScenes(route.sequences[1].scene, MakeClutterRoute(5).sequences[1].scene);
  EXPECT_GT(other.moved.size(), 10U);
}

TEST(MakeClutterRoute, ThingsGoComeAndAreMovedBetweenTheDrives) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Route route = MakeClutterRoute(seed);
    ASSERT_EQ(route.sequences.size(), 3U);
    std::size_t changes = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Scene& scene = route.sequences[i].scene;
      EXPECT_GT(std::count_if(scene.objects().begin(), scene.objects().end(), IsLoose), 20);
      if (i == 0) continue;
      const SceneChange change = CompareScenes(route.sequences[i - 1].scene, scene);
      EXPECT_FALSE(change.created.empty());
      EXPECT_FALSE(change.moved.empty());
      changes += change.removed.size() + change.moved.size();
      for (const std::uint16_t id : change.moved) EXPECT_TRUE(IsLoose(*scene.Find(id)));
    }
    EXPECT_GT(changes, 6U) << "seed " << seed;
  }
}

TEST(MakeClutterRoute, LeavesTheCamerasWayFree) {
  SimulationOptions options;
  options.sensor = SensorModel::Ideal();
  options.stride = 20;
  Simulation simulation(MakeClutterRoute(6), options);
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    const Frame frame = simulation.Render(i);
    const Image<std::uint16_t>& units = frame.depth.units;
    const int pixels = frame.camera.width_px * frame.camera.height_px;
    const auto missing = std::count(units.data(), units.data() + pixels, std::uint16_t{0});
    // The sensor measures from 0.3 to 5 m; above the walls there is no surface.
    EXPECT_LT(static_cast<double>(missing), 0.4 * pixels) << "frame " << i;
  }
}

}  // namespace
}  // namespace steadymap
