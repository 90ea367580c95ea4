#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/dataset/dataset.h"
#include "core/frame/image_codec.h"
#include "tests/client/dataset/files/float_image_writer.h"
#include "tests/client/dataset/recording_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr char kPoses[] = "1 1 2 3 0 0 0 1\n2 4 5 6 0 0 0 1\n";

// Writes two frames of 64 x 48 pixels; masks contain the ids 0 and 2.
void WriteCoFusionRecording(const TemporaryFolder& folder) {
  for (const std::string number : {"0001", "0002"}) {
    Image<std::uint16_t> mask(64, 48);
    mask.At(5, 6) = 2;
    WriteExr(folder.path() / ("depth_original/Depth" + number + ".exr"),
             Image<float>(64, 48, 1.25F),
             "R",
             {.channels = {"R", "G", "B"}});
    folder.Write("mask_id/Mask" + number + ".png", EncodePixels(mask, PixelEncoding::kPng));
    folder.Write("colour/Color" + number + ".png", EncodeColorPng(Image<Rgb>(64, 48, {1, 2, 3})));
  }
  folder.Write("calibration.txt", "60 61 32 24 64 48\n");
  folder.Write("trajectories/gt-cam-0.txt", kPoses);
  folder.Write("trajectories/gt-car-2.txt", "1 0 0 0 0 0 0 1\n");
}

Image<std::uint16_t> PixelsOf(const v1::LabelImage& image) {
  const auto pixels = DecodePixels(
      image.data(),
      image.encoding() == v1::LABEL_ENCODING_PNG ? PixelEncoding::kPng : PixelEncoding::kZstdUint8,
      64,
      48);
  EXPECT_TRUE(pixels.ok()) << pixels.status();
  return pixels.value_or(Image<std::uint16_t>(64, 48));
}

TEST(CoFusionDataset, FramesHoldWhatTheFilesSay) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  const std::vector<v1::Frame> frames = ReadAll("co-fusion", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 2U);
  const v1::Frame& frame = frames[1];
  EXPECT_EQ(frame.world_from_camera().position_m().x(), 4);
  EXPECT_EQ(frame.world_from_camera().position_m().z(), 6);
  EXPECT_EQ(frame.intrinsics().fx(), 60);
  EXPECT_EQ(frame.intrinsics().fy(), 61);
  EXPECT_EQ(frame.intrinsics().width_px(), 64U);
  EXPECT_EQ(TimeOf(frame) - TimeOf(frames[0]), 33'333'333);
  const auto depth = DecodeDepth(frame.depth().data(), PixelEncoding::kZstdUint16, 64, 48);
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_NEAR(depth->At(63, 47) * frame.depth().metres_per_unit(), 1.25, 1e-12);
  EXPECT_EQ(PixelsOf(frame.instances()).At(5, 6), 2);
  EXPECT_EQ(PixelsOf(frame.instances()).At(0, 0), 0);
  EXPECT_EQ(PixelsOf(frame.labels()).At(5, 6), 2);
  EXPECT_EQ(frame.color().data(), ContentOf(folder.path() / "colour/Color0002.png"));
}

TEST(CoFusionDataset, LabelMapGivesMasksTheirClassAndLeavesInstances) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  DatasetOptions options;
  options.label_map_file = folder.Write("map.txt", "2 14\n");
  const v1::Frame frame = ReadAll("co-fusion", {folder.path()}, options).at(0);
  EXPECT_EQ(PixelsOf(frame.labels()).At(5, 6), 14);
  EXPECT_EQ(PixelsOf(frame.instances()).At(5, 6), 2);
}

TEST(CoFusionDataset, NoisyDepthLoadsWhereThereIsNoOther) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  WriteExr(folder.path() / "depth_noise/Depth0001.exr", Image<float>(64, 48, 2.0F));
  EXPECT_EQ(ReadAll("co-fusion", {folder.path()}, {}).size(), 2U);
  fs::remove_all(folder.path() / "depth_original");
  const std::vector<v1::Frame> frames = ReadAll("co-fusion", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 1U);
  const auto depth = DecodeDepth(frames[0].depth().data(), PixelEncoding::kZstdUint16, 64, 48);
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_EQ(depth->At(0, 0), 10'000);
}

TEST(CoFusionDataset, SizeComesFromTheImagesIfTheCalibrationLacksIt) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  folder.Write("calibration.txt", "60 61 32 24\n");
  const v1::Frame frame = ReadAll("co-fusion", {folder.path()}, {}).at(0);
  EXPECT_EQ(frame.intrinsics().height_px(), 48U);
  fs::remove_all(folder.path() / "colour");
  const auto source = OpenDataset("co-fusion", {folder.path()}, {});
  EXPECT_THAT(std::string(source.status().message()), HasSubstr("calibration.txt:1"));
}

TEST(CoFusionDataset, LoadsWithoutMasksAndColour) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  fs::remove_all(folder.path() / "colour");
  fs::remove_all(folder.path() / "mask_id");
  const v1::Frame frame = ReadAll("co-fusion", {folder.path()}, {}).at(0);
  EXPECT_FALSE(frame.has_color() || frame.has_labels() || frame.has_instances());
}

TEST(CoFusionDataset, FramesWithoutAPoseAreSkipped) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  folder.Write("trajectories/gt-cam-0.txt", "1 nan 2 3 0 0 0 1\n2 4 5 6 0 0 0 1\n");
  const auto source = OpenDataset("co-fusion", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->skipped_count(), 1U);
  EXPECT_EQ((*source)->frame_count(), 1U);
}

TEST(CoFusionDataset, RefusesTextThatIsMissingOrMalformed) {
  struct Case {
    const char* file;
    const char* text;  // Null: removed.
  };

  for (const Case& c : {Case{"gt-cam-0.txt", nullptr},
                        Case{"gt-cam-0.txt", "1 2 3\n"},
                        Case{"gt-cam-0.txt", "1.5 1 2 3 0 0 0 1\n"},
                        Case{"gt-cam-0.txt", "1e300 1 2 3 0 0 0 1\n"},
                        Case{"gt-cam-0.txt", "1 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n"},
                        Case{"calibration.txt", ""},
                        Case{"calibration.txt", "60 61 32\n"},
                        Case{"calibration.txt", "a b c d\n"},
                        Case{"calibration.txt", "60 61 32 24 0 48\n"},
                        Case{"calibration.txt", "60 61 32 24 1e9 1e9\n"},
                        Case{"calibration.txt", "-60 61 32 24 64 48\n"}}) {
    const TemporaryFolder folder;
    WriteCoFusionRecording(folder);
    const bool is_pose = std::string(c.file) == "gt-cam-0.txt";
    const std::string name = is_pose ? std::string("trajectories/") + c.file : c.file;
    if (c.text != nullptr) {
      folder.Write(name, c.text);
    } else {
      fs::remove(folder.path() / name);
    }
    const auto source = OpenDataset("co-fusion", {folder.path()}, {});
    ASSERT_FALSE(source.ok()) << c.file << " " << (c.text != nullptr ? c.text : "");
    EXPECT_THAT(std::string(source.status().message()), HasSubstr(c.file));
  }
}

TEST(CoFusionDataset, BrokenImagesAndRotationsAreErrorsOfTheirFrame) {
  const TemporaryFolder folder;
  WriteCoFusionRecording(folder);
  folder.Write("depth_original/Depth0001.exr", "no image");
  folder.Write("trajectories/gt-cam-0.txt", "1 1 2 3 0 0 0 1\n2 4 5 6 0 0 0 7\n");
  auto source = OpenDataset("co-fusion", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("Depth0001.exr"));
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("gt-cam-0.txt:2"));
}

}  // namespace
}  // namespace steadymap
