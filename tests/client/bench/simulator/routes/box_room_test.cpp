#include "client/bench/simulator/routes/box_room.h"

#include <algorithm>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "client/bench/simulator/simulation.h"

namespace steadymap {
namespace {

std::size_t CountEvents(const BoxRoom& room, EventType type) {
  return static_cast<std::size_t>(
      std::count_if(room.events.begin(), room.events.end(), [type](const RoomEvent& event) {
        return event.type == type;
      }));
}

TEST(MakeBoxRoom, ListsOneEventForEachChange) {
  struct Expected {
    RoomChange change;
    std::size_t removed;
    std::size_t moved;
    std::size_t returned;
  };

  for (const Expected& expected : {Expected{RoomChange::kNothing, 0, 0, 0},
                                   Expected{RoomChange::kRemoved, 1, 0, 0},
                                   Expected{RoomChange::kKnownRemovedInView, 1, 0, 0},
                                   Expected{RoomChange::kMoved5Cm, 0, 1, 0},
                                   Expected{RoomChange::kTurned15Deg, 0, 1, 0},
                                   Expected{RoomChange::kSwappedShapes, 0, 2, 0},
                                   Expected{RoomChange::kSwappedTwins, 0, 0, 0},
                                   Expected{RoomChange::kBackInPlace, 1, 0, 1},
                                   Expected{RoomChange::kLowerRemoved, 1, 1, 0},
                                   Expected{RoomChange::kNeighbourAt3CmRemoved, 1, 0, 0}}) {
    SCOPED_TRACE(NameOf(expected.change));
    const BoxRoom room = MakeBoxRoom(expected.change, {});
    EXPECT_EQ(CountEvents(room, EventType::kRemoved), expected.removed);
    EXPECT_EQ(CountEvents(room, EventType::kMoved), expected.moved);
    EXPECT_EQ(CountEvents(room, EventType::kReturned), expected.returned);
    EXPECT_EQ(CountEvents(room, EventType::kCreated) - room.objects.size(),
              expected.removed - expected.returned);
  }
}

TEST(MakeBoxRoom, EveryChangeHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (const RoomChange change : AllRoomChanges()) names.insert(NameOf(change));
  EXPECT_EQ(names.size(), AllRoomChanges().size());
  EXPECT_EQ(NameOf(RoomChange::kKnownRemovedInView), "known-removed-in-view");
}

/// Returns the number of pixels of a frame that show a surface of `object`.
std::size_t CountPixels(const SurfaceImage& surfaces, std::uint16_t object) {
  const Image<std::uint32_t>& image = surfaces.pixels.surface;
  return static_cast<std::size_t>(
      std::count_if(image.data(), image.data() + image.size(), [&](std::uint32_t surface) {
        const SceneObject* seen = surfaces.surfaces[surface].object;
        return seen != nullptr && seen->id == object;
      }));
}

TEST(MakeBoxRoom, TheLastDriveSeesWhatChangesFromEveryPathAndHeight) {
  for (const RoomPath path : {RoomPath::kOrbit, RoomPath::kPass, RoomPath::kLook}) {
    for (const double height_m : {0.3, 0.9, 1.5, 2.0}) {
      BoxRoomSetting setting;
      setting.path = path;
      setting.camera_height_m = height_m;
      setting.looks_down = height_m > 1.0;
      const BoxRoom room = MakeBoxRoom(RoomChange::kMoved30Cm, setting);
      const RouteSequence& before = room.route.sequences.front();
      const RouteSequence& after = room.route.sequences.back();
      const SceneChange change = CompareScenes(before.scene, after.scene);
      ASSERT_EQ(change.moved.size(), 1U);
      Renderer renderer(&after.scene, room.route.camera, SensorModel::Ideal());
      std::size_t most = 0;
      const int frames = static_cast<int>(after.trajectory.duration_s / 0.2);
      for (int frame = 0; frame <= frames; ++frame) {
        const double time_s = 0.2 * frame;
        const SurfaceImage& seen =
            renderer.RenderSurfaces(after.trajectory.T_world_camera(time_s), time_s);
        most = std::max(most, CountPixels(seen, change.moved[0]));
      }
      EXPECT_GT(most, 3000U) << "path " << static_cast<int>(path) << ", " << height_m << " m";
    }
  }
}

TEST(MakeBoxRoom, ALookIsThreeFrames) {
  BoxRoomSetting setting;
  setting.path = RoomPath::kLook;
  const BoxRoom room = MakeBoxRoom(RoomChange::kRemoved, setting);
  SimulationOptions options;
  const Simulation simulation(room.route, options);
  std::size_t frames = 0;
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    if (simulation.SequenceOf(i) == 1) ++frames;
  }
  EXPECT_EQ(frames, 3U);
}

TEST(MakeBoxRoom, TheCameraStopsHalfWayOnEachDriveThatIsNoLook) {
  const BoxRoom room = MakeBoxRoom(RoomChange::kRemoved, {.path = RoomPath::kLook, .stops = true});
  EXPECT_GT(room.route.sequences[0].trajectory.stop_s, 10.0);
  EXPECT_EQ(room.route.sequences[1].trajectory.stop_s, 0.0);
}

TEST(MakeBoxRoom, TheWholeRoomStandsOnItsFloor) {
  BoxRoomSetting setting;
  setting.floor_world_m = 7.0;
  setting.slope_rad = 0.05;
  const BoxRoom level = MakeBoxRoom(RoomChange::kNothing, {});
  const BoxRoom sloping = MakeBoxRoom(RoomChange::kNothing, setting);
  const auto depth_of = [](const BoxRoom& room) {
    SimulationOptions options;
    options.sensor = SensorModel::Ideal();
    return Simulation(room.route, options).Render(7).depth.units;
  };
  const Image<std::uint16_t> expected = depth_of(level);
  const Image<std::uint16_t> actual = depth_of(sloping);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_NEAR(actual.data()[i], expected.data()[i], 1) << "pixel " << i;
  }
}

}  // namespace
}  // namespace steadymap
