#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/dataset/dataset.h"
#include "client/dataset/layouts/torwic_layout.h"
#include "core/frame/image_codec.h"
#include "tests/client/dataset/recording_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(TorwicDataset, CameraSitsWhereTheCalibrationPutsIt) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 2, .x_m = 3});
  const std::vector<v1::Frame> frames = ReadAll("torwic", {folder.path() / "sequence"}, {});
  ASSERT_EQ(frames.size(), 2U);
  const v1::Frame& frame = frames[1];
  EXPECT_NEAR(frame.world_from_camera().position_m().x(), 3.1 + 0.520, 1e-9);
  EXPECT_NEAR(frame.world_from_camera().position_m().y(), 0.032, 1e-9);
  EXPECT_NEAR(frame.world_from_camera().position_m().z(), 0.011, 1e-9);
  const v1::Quaternion& q = frame.world_from_camera().orientation();
  const Eigen::Vector3d sight =
      Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) * Eigen::Vector3d::UnitZ();
  EXPECT_GT(sight.x(), 0.95);
  EXPECT_GT(sight.z(), 0.2);
  EXPECT_EQ(frame.intrinsics().fx(), 461.0956);
  EXPECT_EQ(frame.intrinsics().width_px(), 640U);
  EXPECT_EQ(TimeOf(frame), 1'600'000'000'100'000'000);
  EXPECT_EQ(frame.depth().encoding(), v1::DEPTH_ENCODING_PNG_UINT16);
  EXPECT_EQ(frame.depth().data(), ContentOf(folder.path() / "sequence/Depth/0001.png"));
  EXPECT_FALSE(frame.has_color());
  EXPECT_FALSE(frame.has_instances());
}

TEST(TorwicDataset, LowerCaseSpellingAndInstancesLoadAsWell) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "s", {.frame_count = 1, .has_color = true});
  fs::rename(folder.path() / "s/Depth", folder.path() / "s/depth");
  fs::rename(folder.path() / "s/Segmentation", folder.path() / "s/segmentation");
  fs::rename(folder.path() / "s/RGB", folder.path() / "s/rgb");
  folder.Write("s/instances/0000.png", DepthPng(640, 360, 300));
  folder.Write("s/laser scans/0000.csv", "ignored");
  const v1::Frame frame = ReadAll("torwic", {folder.path()}, {}).at(0);
  EXPECT_TRUE(frame.has_labels() && frame.has_color());
  const auto instances = DecodePixels(frame.instances().data(), PixelEncoding::kPng, 640, 360);
  ASSERT_TRUE(instances.ok());
  EXPECT_EQ(instances->At(3, 3), 300);
}

TEST(TorwicDataset, OwnCalibrationReplacesThePublishedOne) {
  const TemporaryFolder folder;
  folder.Write("s/Depth/0000.png", DepthPng(80, 60, 500));
  folder.Write("s/poses.txt", "0 5 0 1 2 3 0 0 0 1\n");
  folder.Write("s/calibration.txt",
               "# ours\nw=80 h=60 fx=70 fy=71 cx=40 cy=30\n0.1 0 0 0 0 0 1\n0.0005\n");
  const v1::Frame frame = ReadAll("torwic", {folder.path()}, {}).at(0);
  EXPECT_EQ(frame.intrinsics().height_px(), 60U);
  EXPECT_EQ(frame.intrinsics().fy(), 71);
  EXPECT_EQ(frame.depth().metres_per_unit(), 0.0005);
  EXPECT_NEAR(frame.world_from_camera().position_m().x(), 1.1, 1e-12);
  EXPECT_FALSE(frame.has_labels());
}

TEST(TorwicCalibration, TextReadsBackAsItWas) {
  const TemporaryFolder folder;
  const TorwicCalibration written = DefaultTorwicCalibration();
  const auto read =
      LoadTorwicCalibration(folder.Write("calibration.txt", FormatTorwicCalibration(written)));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->camera, written.camera);
  EXPECT_TRUE(read->T_base_camera.isApprox(written.T_base_camera, 1e-15));
  EXPECT_EQ(read->metres_per_unit, written.metres_per_unit);
}

TEST(TorwicCalibration, RefusesGarbageNamingTheLine) {
  const TemporaryFolder folder;
  const std::string camera = "w=640 h=360 fx=461 fy=460 cx=325 cy=177\n";
  const std::string pose = "0 0 0 0 0 0 1\n";

  struct Case {
    std::string text;
    const char* where;
  };

  const std::vector<Case> cases = {
      Case{"", "calibration.txt"},
      Case{camera + pose, "calibration.txt"},
      Case{camera + pose + "0.001\nmore\n", "calibration.txt"},
      Case{"w=640 h=360\n" + pose + "0.001\n", "calibration.txt:1"},
      Case{"w=0" + camera.substr(5) + pose + "0.001\n", "calibration.txt:1"},
      Case{"w=1e300" + camera.substr(5) + pose + "0.001\n", "calibration.txt:1"},
      Case{"w=nan" + camera.substr(5) + pose + "0.001\n", "calibration.txt:1"},
      Case{"z=1 " + camera + pose + "0.001\n", "calibration.txt:1"},
      Case{camera + "0 0 0 0 0 0 0\n0.001\n", "calibration.txt:2"},
      Case{camera + "0 0 0\n0.001\n", "calibration.txt:2"},
      Case{camera + pose + "0\n", "calibration.txt:3"},
      Case{camera + pose + "nan\n", "calibration.txt:3"}};
  for (const Case& c : cases) {
    const auto read = LoadTorwicCalibration(folder.Write("calibration.txt", c.text));
    EXPECT_FALSE(read.ok()) << c.text;
    EXPECT_THAT(std::string(read.status().message()), HasSubstr(c.where)) << c.text;
  }
}

TEST(TorwicDataset, FramesWithoutAFinitePoseAreSkippedAndCounted) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "s", {.frame_count = 4});
  folder.Write("s/poses.txt",
               "0 10 0 0 0 0 0 0 0 1\n"
               "1 11 0 nan 0 0 0 0 0 1\n"
               "2 12 0 0 0 0 0 0 inf 1\n");
  auto source = OpenDataset("torwic", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame_count(), 1U);
  EXPECT_EQ((*source)->skipped_count(), 3U);  // The fourth image has no line.
}

TEST(TorwicDataset, GarbagePoseIsAnErrorOfItsFrameAlone) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "s", {.frame_count = 5});
  folder.Write("s/poses.txt",
               "0 10 0 0 0 0 0 0 0 1\n"
               "1 eleven 0 0 0 0 0 0 0 1\n"
               "2 12 0 0 0 0 1 1 1 1\n"
               "3 13 0 0 0 0 0 0 1\n"
               "4 14 0 0 0 0 0 0 0 1\n");
  auto source = OpenDataset("torwic", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_TRUE((*source)->Next().ok());
  for (const char* line : {"poses.txt:2", "poses.txt:3", "poses.txt:4"}) {
    const auto frame = (*source)->Next();
    EXPECT_EQ(frame.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(frame.status().message()), HasSubstr(line));
  }
  const auto last = (*source)->Next();
  ASSERT_TRUE(last.ok() && last->has_value());
  EXPECT_EQ(TimeOf(**last), 14'000'000'000);
}

TEST(TorwicDataset, BadImagesAreErrorsThatNameTheFile) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "s", {.frame_count = 4});
  folder.Write("s/Depth/0000.png", DepthPng(320, 180, 5));
  folder.Write("s/Depth/0001.png", "not a picture");
  folder.Write("s/Segmentation/0002.png", "");
  auto source = OpenDataset("torwic", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  fs::remove(folder.path() / "s/Depth/0003.png");
  for (const char* file :
       {"Depth/0000.png", "Depth/0001.png", "Segmentation/0002.png", "Depth/0003.png"}) {
    const auto frame = (*source)->Next();
    ASSERT_FALSE(frame.ok()) << file;
    EXPECT_THAT(std::string(frame.status().message()), HasSubstr(file));
    EXPECT_THAT(std::string(frame.status().message()), HasSubstr("expected"));
  }
  const auto end = (*source)->Next();
  EXPECT_TRUE(end.ok() && !end->has_value());
}

TEST(TorwicDataset, RecordingsThatDoNotFitTogetherAreRefused) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "s", {.frame_count = 3});
  fs::remove(folder.path() / "s/Segmentation/0001.png");
  const auto mismatched = OpenDataset("torwic", {folder.path()}, {});
  EXPECT_THAT(std::string(mismatched.status().message()), HasSubstr("Segmentation"));
  fs::remove_all(folder.path() / "s/Segmentation");
  EXPECT_TRUE(OpenDataset("torwic", {folder.path()}, {}).ok());
  folder.Write("s/poses.txt", "# nothing\n");
  const auto without_poses = OpenDataset("torwic", {folder.path()}, {});
  EXPECT_THAT(std::string(without_poses.status().message()), HasSubstr("pose"));
  fs::remove(folder.path() / "s/poses.txt");
  EXPECT_EQ(OpenDataset("torwic", {folder.path() / "s"}, {}).status().code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace steadymap
