#include "client/bench/simulator/simulation.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/bench/simulator/routes/large_hall.h"
#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/simulated_frame_source.h"
#include "core/frame/image_codec.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

Route RouteOf(std::string_view name) {
  absl::StatusOr<Route> route = MakeRoute(name);
  EXPECT_TRUE(route.ok()) << route.status();
  return *std::move(route);
}

std::vector<std::string> SequenceNames(std::string_view route) {
  std::vector<std::string> names;
  for (const RouteSequence& sequence : RouteOf(route).sequences) names.push_back(sequence.name);
  return names;
}

SimulationOptions Full(std::uint64_t seed) {
  SimulationOptions options;
  options.sensor = SensorModel::Full();
  options.seed = seed;
  return options;
}

void ExpectSame(const Frame& a, const Frame& b) {
  EXPECT_EQ(a.capture_time, b.capture_time);
  EXPECT_TRUE(a.T_world_camera.matrix() == b.T_world_camera.matrix());
  EXPECT_TRUE(a.depth == b.depth);
  EXPECT_TRUE(a.labels == b.labels);
  EXPECT_TRUE(a.instances == b.instances);
  EXPECT_TRUE(a.color == b.color);
}

TEST(MakeRoute, KnowsItsRoutesAndTheirSequences) {
  EXPECT_THAT(SequenceNames("baseline"), ::testing::ElementsAre("baseline"));
  EXPECT_THAT(SequenceNames("1-5"), ::testing::ElementsAre("baseline", "1-5"));
  EXPECT_THAT(SequenceNames("2-4-4"), ::testing::ElementsAre("2-2", "2-4", "4-1"));
  EXPECT_THAT(SequenceNames("9-2"), ::testing::ElementsAre("1-9", "2-1"));
  EXPECT_THAT(SequenceNames("unchanged"), ::testing::ElementsAre("baseline", "baseline"));
  EXPECT_THAT(RouteNames(),
              ::testing::IsSupersetOf({"4-1", "table-top", "twin", "people", "clutter", "hall"}));
  for (const std::string& name : RouteNames()) {
    EXPECT_EQ(RouteOf(name).name, name);
    EXPECT_TRUE(ValidateCamera(RouteOf(name).camera).ok());
  }
}

TEST(MakeRoute, RefusesAnUnknownNameAndListsTheKnown) {
  for (const char* name :
       {"", "nowhere", "5-1", "1-5-1", "baseline ", "clutter-", "clutter-x", "clutter7"}) {
    const absl::Status status = MakeRoute(name).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << name;
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("2-4-4")) << name;
  }
}

TEST(Simulation, TakesNoFramesWhileTheCameraStops) {
  Route route = RouteOf("baseline");
  Trajectory& trajectory = route.sequences.front().trajectory;
  trajectory.stop_s = 15.0;
  Simulation simulation(route, {});
  std::size_t stops = 0;
  for (std::size_t i = 1; i < simulation.frame_count(); ++i) {
    const Duration step = simulation.CaptureTimeOf(i) - simulation.CaptureTimeOf(i - 1);
    if (step.seconds() < 15.0) continue;
    ++stops;
    EXPECT_NEAR(step.seconds(), 15.0 + trajectory.frame_period_s, 1e-6);
  }
  EXPECT_EQ(stops, 1U);
}

TEST(MakeRoute, EveryRouteShowsSomethingInEverySequence) {
  for (const std::string& name : RouteNames()) {
    SimulationOptions options;
    options.stride = 100;
    Simulation simulation(RouteOf(name), options);
    std::set<std::size_t> sequences;
    for (std::size_t i = 0; i < simulation.frame_count(); i += name == "hall" ? 10 : 1) {
      const Frame frame = simulation.Render(i);
      ASSERT_TRUE(ValidateFrame(frame, KnownLabels(MapConfig().classes)).ok());
      const auto& units = frame.depth.units;
      const auto lost = std::count(units.data(), units.data() + units.size(), kNoDepth);
      EXPECT_LT(static_cast<double>(lost), 0.95 * static_cast<double>(units.size())) << name;
      sequences.insert(simulation.SequenceOf(i));
    }
    EXPECT_EQ(sequences.size(), simulation.route().sequences.size()) << name;
  }
}

TEST(Simulation, FrameDoesNotDependOnWhatWasRenderedBefore) {
  Simulation forward(RouteOf("2-1"), Full(4));
  Simulation backward(RouteOf("2-1"), Full(4));
  const std::vector<std::size_t> indices = {3, 200, 400, 700};
  std::vector<Frame> frames;
  frames.reserve(indices.size());
  for (const std::size_t index : indices) frames.push_back(forward.Render(index));
  for (std::size_t i = indices.size(); i-- > 0;) {
    ExpectSame(backward.Render(indices[i]), frames[i]);
  }
}

TEST(Simulation, AnotherSeedGivesOtherNoiseAndTheSameTruth) {
  Simulation first(RouteOf("baseline"), Full(1));
  Simulation second(RouteOf("baseline"), Full(2));
  EXPECT_FALSE(first.Render(50).depth == second.Render(50).depth);
  EXPECT_TRUE(first.TruePose(50).matrix() == second.TruePose(50).matrix());
}

TEST(Simulation, ALostRobotIsWrongAboutItsPoseAlone) {
  SimulationOptions options = Full(1);
  const Simulation truth(RouteOf("1-1"), options);
  Simulation sound(RouteOf("1-1"), options);
  options.lost = {.first_frame = 20, .frame_count = 3, .shift_m = 1.5, .turn_rad = 0.7};
  Simulation misled(RouteOf("1-1"), options);
  ExpectSame(misled.Render(19), sound.Render(19));
  ExpectSame(misled.Render(23), sound.Render(23));
  const Eigen::Isometry3d T_world_first = sound.Render(20).T_world_camera;
  for (const std::size_t index : {20U, 22U}) {
    Frame lost = misled.Render(index);
    const Frame frame = sound.Render(index);
    const Eigen::Isometry3d T_true_misled = frame.T_world_camera * lost.T_world_camera.inverse();
    EXPECT_NEAR(Eigen::AngleAxisd(T_true_misled.linear()).angle(), 0.7, 1e-9);
    EXPECT_TRUE((T_world_first.inverse() * frame.T_world_camera)
                    .isApprox(misled.Render(20).T_world_camera.inverse() * lost.T_world_camera))
        << "the drift depends on time only";
    lost.T_world_camera = frame.T_world_camera;
    ExpectSame(lost, frame);
  }
  EXPECT_NEAR((misled.Render(20).T_world_camera.translation() - T_world_first.translation()).norm(),
              1.5,
              0.03);
  EXPECT_TRUE(misled.TruePose(21).isApprox(truth.TruePose(21)));
}

TEST(Simulation, StridePicksFramesWithoutChangingThem) {
  SimulationOptions strided = Full(1);
  strided.stride = 7;
  Simulation every(RouteOf("2-1"), Full(1));
  Simulation some(RouteOf("2-1"), strided);
  EXPECT_EQ(some.frame_count(), 2 * ((every.frame_count() / 2 + 6) / 7));
  ExpectSame(some.Render(3), every.Render(21));
}

TEST(Simulation, TimesRiseAcrossSequences) {
  SimulationOptions options;
  options.stride = 50;
  options.sensor = SensorModel::Ideal();
  options.source = {"forklift-7", "left"};
  Simulation simulation(RouteOf("2-4-4"), options);
  Timestamp last = Timestamp::FromNanoseconds(options.start_time.nanoseconds() - 1);
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    const Frame frame = simulation.Render(i);
    EXPECT_GT(frame.capture_time, last);
    EXPECT_EQ(frame.source, options.source);
    EXPECT_TRUE(frame.T_world_camera.matrix() == simulation.TruePose(i).matrix());
    last = frame.capture_time;
  }
}

TEST(Simulation, InstancesFollowTheRouteUnlessTold) {
  SimulationOptions options;
  EXPECT_TRUE(Simulation(RouteOf("baseline"), options).Render(0).instances.empty());
  EXPECT_FALSE(Simulation(RouteOf("table-top"), options).Render(0).instances.empty());
  options.include_instances = true;
  EXPECT_FALSE(Simulation(RouteOf("baseline"), options).Render(0).instances.empty());
  options.include_instances = false;
  EXPECT_TRUE(Simulation(RouteOf("table-top"), options).Render(0).instances.empty());
}

TEST(TableTop, BothCarsAreSeenMoving) {
  const Route route = RouteOf("table-top");
  int car_count = 0;
  for (const SceneObject& object : route.sequences[0].scene.objects()) {
    if (!object.moves()) continue;
    ++car_count;
    EXPECT_GT((object.PoseAt(8).translation() - object.PoseAt(0).translation()).norm(), 0.2);
    EXPECT_NEAR(object.PoseAt(5).translation().z(), 0.72, 1e-9);
  }
  EXPECT_EQ(car_count, 2);
}

TEST(Twin, SwapIsInvisibleAndTheLeavingIsNot) {
  SimulationOptions options;
  options.sensor = SensorModel::Ideal();
  Simulation simulation(RouteOf("twin"), options);
  const std::size_t count = simulation.frame_count() / 3;
  EXPECT_TRUE(simulation.Render(5).depth == simulation.Render(count + 5).depth);
  EXPECT_FALSE(simulation.Render(5).depth == simulation.Render(2 * count + 5).depth);
  const auto& sequences = simulation.route().sequences;
  EXPECT_EQ(CompareScenes(sequences[0].scene, sequences[1].scene).moved.size(), 2U);
  EXPECT_EQ(CompareScenes(sequences[1].scene, sequences[2].scene).removed.size(), 1U);
}

TEST(People, AreSeenAndNeverTouchTheCamera) {
  SimulationOptions options;
  options.sensor = SensorModel::Ideal();
  options.stride = 4;
  Simulation simulation(RouteOf("people"), options);
  std::set<std::uint16_t> seen;
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    const Frame frame = simulation.Render(i);
    seen.insert(frame.labels.data(), frame.labels.data() + frame.labels.size());
    const double time_s = static_cast<double>(4 * i) * 0.1;
    for (const SceneObject& object : simulation.route().sequences[0].scene.objects()) {
      if (!object.moves()) continue;
      const Eigen::Vector3d between =
          object.PoseAt(time_s).translation() - frame.T_world_camera.translation();
      EXPECT_GT(between.head<2>().norm(), 0.3) << object.name << " at " << time_s;
    }
  }
  EXPECT_TRUE(seen.contains(13));
  EXPECT_TRUE(seen.contains(14));
}

TEST(LargeHall, GrowsWithItsAislesAndIsOfItsSeed) {
  const auto count = [](int aisles, std::uint64_t seed) {
    const absl::StatusOr<Route> route =
        MakeLargeHallRoute({.aisles = aisles, .aisle_length_m = 20, .seed = seed});
    EXPECT_TRUE(route.ok()) << route.status();
    return route->sequences[0].scene.objects().size();
  };
  EXPECT_EQ(count(2, 1), count(2, 1));
  EXPECT_NE(count(2, 1), count(2, 2));
  EXPECT_GT(count(6, 1), 2 * count(2, 1));
  EXPECT_GT(RouteOf("hall").sequences[0].scene.objects().size(), 2000U);
}

TEST(LargeHall, RefusesSizesOutOfRange) {
  EXPECT_FALSE(MakeLargeHallRoute({.aisles = 0}).ok());
  EXPECT_FALSE(MakeLargeHallRoute({.aisles = 61}).ok());
  EXPECT_FALSE(MakeLargeHallRoute({.aisle_length_m = 1000}).ok());
  EXPECT_FALSE(MakeLargeHallRoute({.filled_share = -0.1}).ok());
  EXPECT_FALSE(MakeLargeHallRoute({.aisle_length_m = std::nan("")}).ok());
  EXPECT_TRUE(MakeLargeHallRoute({.aisles = 60, .aisle_length_m = 100}).ok());
}

TEST(SimulatedFrameSource, PacksWhatTheSimulationRenders) {
  SimulationOptions options = Full(3);
  options.stride = 60;
  options.include_color = true;
  options.include_instances = true;
  auto source = SimulatedFrameSource::Open("baseline", options);
  ASSERT_TRUE(source.ok()) << source.status();
  Simulation simulation(RouteOf("baseline"), options);
  EXPECT_EQ((*source)->frame_count(), simulation.frame_count());
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    const auto message = (*source)->Next();
    ASSERT_TRUE(message.ok() && message->has_value());
    const Frame frame = simulation.Render(i);
    EXPECT_EQ((*message)->depth().encoding(), v1::DEPTH_ENCODING_ZSTD_UINT16);
    const auto depth =
        DecodeDepth((*message)->depth().data(), PixelEncoding::kZstdUint16, 640, 360);
    EXPECT_TRUE(depth.ok() && *depth == frame.depth.units);
    EXPECT_EQ((*message)->labels().encoding(), v1::LABEL_ENCODING_ZSTD_UINT8);
    const auto labels =
        DecodePixels((*message)->labels().data(), PixelEncoding::kZstdUint8, 640, 360);
    EXPECT_TRUE(labels.ok() && *labels == frame.labels);
    const auto instances =
        DecodePixels((*message)->instances().data(), PixelEncoding::kZstdUint8, 640, 360);
    EXPECT_TRUE(instances.ok() && *instances == frame.instances);
    const auto color = DecodeColor((*message)->color().data(), ColorEncoding::kPng, 640, 360);
    EXPECT_TRUE(color.ok() && *color == frame.color);
    EXPECT_EQ((*message)->world_from_camera().position_m().x(),
              frame.T_world_camera.translation().x());
    EXPECT_EQ(
        (*message)->capture_time().seconds() * 1'000'000'000 + (*message)->capture_time().nanos(),
        frame.capture_time.nanoseconds());
  }
  const auto end = (*source)->Next();
  EXPECT_TRUE(end.ok() && !end->has_value());
}

TEST(SimulatedFrameSource, RefusesAnUnknownRouteAndAStrideOfZero) {
  EXPECT_FALSE(SimulatedFrameSource::Open("nowhere", {}).ok());
  SimulationOptions options;
  options.stride = 0;
  EXPECT_EQ(FieldOf(SimulatedFrameSource::Open("baseline", options).status()), "stride");
}

}  // namespace
}  // namespace steadymap
