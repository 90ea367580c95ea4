#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/dataset/dataset.h"
#include "core/frame/image_codec.h"
#include "tests/client/dataset/recording_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr char kPose[] = "1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n";

void WriteFrame(const TemporaryFolder& folder, const std::string& stem, const char* pose) {
  folder.Write(stem + ".depth.png", DepthPng(640, 480, 65535));
  folder.Write(stem + ".pose.txt", pose);
}

TEST(SevenScenesDataset, WorldIsTurnedToHaveZUp) {
  const TemporaryFolder folder;
  WriteFrame(folder, "seq-01/frame-000000", kPose);
  WriteFrame(folder, "seq-01/frame-000003", kPose);
  folder.Write("seq-01/frame-000003.color.png", EncodeColorPng(Image<Rgb>(640, 480)));
  const std::vector<v1::Frame> frames = ReadAll("seven-scenes", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 2U);
  const v1::Frame& frame = frames[1];
  EXPECT_NEAR(frame.world_from_camera().position_m().x(), 1, 1e-12);
  EXPECT_NEAR(frame.world_from_camera().position_m().y(), 3, 1e-12);
  EXPECT_NEAR(frame.world_from_camera().position_m().z(), -2, 1e-12);
  EXPECT_EQ(frame.intrinsics().fx(), 585);
  EXPECT_EQ(frame.intrinsics().cy(), 240);
  EXPECT_EQ(frame.depth().metres_per_unit(), 0.001);
  EXPECT_TRUE(frame.has_color());
  EXPECT_FALSE(frames[0].has_color());
  EXPECT_EQ(TimeOf(frame) - TimeOf(frames[0]), 99'999'999);  // Three frames at 30 Hz.
}

TEST(SevenScenesDataset, OwnCameraMatrixIsUsed) {
  const TemporaryFolder folder;
  folder.Write("frame-000000.depth.png", DepthPng(320, 240, 800));
  folder.Write("frame-000000.pose.txt", kPose);
  folder.Write("camera-intrinsics.txt", "290 0 161\n0 291 119\n0 0 1\n");
  const v1::Frame frame = ReadAll("seven-scenes", {folder.path()}, {}).at(0);
  EXPECT_EQ(frame.intrinsics().width_px(), 320U);
  EXPECT_EQ(frame.intrinsics().fy(), 291);
  EXPECT_EQ(frame.intrinsics().cx(), 161);
  folder.Write("camera-intrinsics.txt", "0 0 161\n0 291 119\n0 0 1\n");
  EXPECT_THAT(std::string(OpenDataset("seven-scenes", {folder.path()}, {}).status().message()),
              HasSubstr("camera-intrinsics.txt"));
}

TEST(SevenScenesDataset, LostPosesAreSkippedAndBrokenOnesAreErrors) {
  const TemporaryFolder folder;
  WriteFrame(folder, "frame-000000", "nan 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n");
  WriteFrame(folder, "frame-000001", "-1 0 0 1\n0 1 0 2\n0 0 1 3\n0 0 0 1\n");
  WriteFrame(folder, "frame-000002", "1 0 0 1\n0 1 0 2\n");
  WriteFrame(folder, "frame-000003", kPose);
  folder.Write("frame-000004.depth.png", DepthPng(640, 480, 1));  // Without a pose.
  auto source = OpenDataset("seven-scenes", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->skipped_count(), 2U);
  EXPECT_EQ((*source)->frame_count(), 3U);
  for (const char* file : {"frame-000001.pose.txt", "frame-000002.pose.txt"}) {
    const auto frame = (*source)->Next();
    EXPECT_THAT(std::string(frame.status().message()), HasSubstr(file));
  }
  EXPECT_TRUE((*source)->Next().ok());
}

TEST(SevenScenesDataset, WrongSizeIsAnErrorOfTheFrame) {
  const TemporaryFolder folder;
  WriteFrame(folder, "frame-000000", kPose);
  folder.Write("frame-000000.color.png", EncodeColorPng(Image<Rgb>(64, 48)));
  auto source = OpenDataset("seven-scenes", {folder.path()}, {});
  ASSERT_TRUE(source.ok());
  const std::string message((*source)->Next().status().message());
  EXPECT_THAT(message, HasSubstr("frame-000000.color.png"));
  EXPECT_THAT(message, HasSubstr("640 x 480"));
  EXPECT_THAT(message, HasSubstr("64 x 48"));
}

TEST(SevenScenesDataset, RealKitchenSequenceLoads) {
  const char* shared = std::getenv("STEADYMAP_SHARED_DATA");  // NOLINT(concurrency-mt-unsafe)
  const fs::path kitchen =
      fs::path(shared != nullptr ? shared : STEADYMAP_SHARED_DATA) / "7scenes-kitchen";
  if (!fs::is_directory(kitchen)) GTEST_SKIP() << "not on this machine";
  auto source = OpenDataset("seven-scenes", {kitchen}, {.stride = 25});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame_count(), 12U);
  EXPECT_EQ((*source)->skipped_count(), 0U);
  std::int64_t last_time = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    const auto frame = (*source)->Next();
    ASSERT_TRUE(frame.ok() && frame->has_value()) << frame.status();
    const auto depth = DecodeDepth((*frame)->depth().data(), PixelEncoding::kPng, 640, 480);
    ASSERT_TRUE(depth.ok()) << depth.status();
    EXPECT_TRUE(DecodeColor((*frame)->color().data(), ColorEncoding::kJpeg, 640, 480).ok());
    EXPECT_GT(TimeOf(**frame), last_time);
    last_time = TimeOf(**frame);
    // A hand-held camera is upright: its y axis points down in a world with z up.
    const v1::Quaternion& q = (*frame)->world_from_camera().orientation();
    const Eigen::Vector3d down =
        Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) * Eigen::Vector3d::UnitY();
    EXPECT_LT(down.z(), -0.7);
  }
}

}  // namespace
}  // namespace steadymap
