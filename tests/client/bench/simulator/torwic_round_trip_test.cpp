#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/bench/simulator/routes/named_routes.h"
#include "client/bench/simulator/torwic_writer.h"
#include "client/dataset/dataset.h"
#include "core/frame/image_codec.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

SimulationOptions Options() {
  SimulationOptions options;
  options.sensor = SensorModel::Full();
  options.stride = 90;
  options.include_color = true;
  options.include_instances = true;
  return options;
}

Eigen::Isometry3d PoseOf(const v1::Frame& message) {
  const v1::Pose& pose = message.world_from_camera();
  const v1::Quaternion& q = pose.orientation();
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.linear() = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).toRotationMatrix();
  T_world_camera.translation() =
      Eigen::Vector3d(pose.position_m().x(), pose.position_m().y(), pose.position_m().z());
  return T_world_camera;
}

void ExpectHolds(const v1::Frame& message, const Frame& frame) {
  EXPECT_TRUE(PoseOf(message).isApprox(frame.T_world_camera, 1e-12));
  EXPECT_EQ(message.capture_time().seconds() * 1'000'000'000 + message.capture_time().nanos(),
            frame.capture_time.nanoseconds());
  EXPECT_EQ(message.intrinsics().fx(), frame.camera.fx);
  EXPECT_EQ(message.intrinsics().cy(), frame.camera.cy);
  EXPECT_EQ(message.depth().metres_per_unit(), 0.001);
  const auto depth = DecodeDepth(message.depth().data(), PixelEncoding::kPng, 640, 360);
  EXPECT_TRUE(depth.ok() && *depth == frame.depth.units);
  const auto labels = DecodePixels(message.labels().data(), PixelEncoding::kPng, 640, 360);
  EXPECT_TRUE(labels.ok() && *labels == frame.labels);
  const auto instances = DecodePixels(message.instances().data(), PixelEncoding::kPng, 640, 360);
  EXPECT_TRUE(instances.ok() && *instances == frame.instances);
  const auto color = DecodeColor(message.color().data(), ColorEncoding::kPng, 640, 360);
  EXPECT_TRUE(color.ok() && *color == frame.color);
}

TEST(WriteTorwicFolder, LoaderReadsBackWhatTheSimulationRenders) {
  const TemporaryFolder folder;
  const absl::StatusOr<Route> route = MakeRoute("2-1");
  ASSERT_TRUE(route.ok());
  std::size_t reported = 0;
  const absl::Status written = WriteTorwicFolder(
      *route, folder.path(), Options(), [&reported](std::size_t count) { reported = count; });
  ASSERT_TRUE(written.ok()) << written;

  Simulation simulation(*route, Options());
  EXPECT_EQ(reported, simulation.frame_count());
  auto source = OpenDataset("torwic", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  ASSERT_EQ((*source)->frame_count(), simulation.frame_count());
  EXPECT_EQ((*source)->skipped_count(), 0U);
  for (std::size_t i = 0; i < simulation.frame_count(); ++i) {
    const auto message = (*source)->Next();
    ASSERT_TRUE(message.ok() && message->has_value()) << message.status();
    ExpectHolds(**message, simulation.Render(i));
  }
  const auto end = (*source)->Next();
  EXPECT_TRUE(end.ok() && !end->has_value());
}

TEST(WriteTorwicFolder, WritesTheDocumentedLayout) {
  const TemporaryFolder folder;
  SimulationOptions options = Options();
  options.stride = 400;
  ASSERT_TRUE(WriteTorwicFolder(*MakeRoute("1-5"), folder.path(), options).ok());
  for (const char* name : {"01-baseline/Depth/0000.png",
                           "01-baseline/Segmentation/0000.png",
                           "01-baseline/Instances/0000.png",
                           "01-baseline/RGB/0000.png",
                           "01-baseline/calibration.txt",
                           "02-1-5/poses.txt"}) {
    EXPECT_TRUE(std::filesystem::is_regular_file(folder.path() / name)) << name;
  }
  EXPECT_THAT(ContentOf(folder.path() / "01-baseline/poses.txt"),
              ::testing::StartsWith("0 1650000000 0 "));
}

TEST(WriteTorwicFolder, NamesTheFolderThatCannotBeCreated) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.Write("taken", "a file, not a folder");
  const absl::Status status = WriteTorwicFolder(*MakeRoute("baseline"), file, Options());
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr(file.string()));
}

}  // namespace
}  // namespace steadymap
