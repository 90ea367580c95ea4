#include <cmath>

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

constexpr int kWidth = 640;
constexpr int kHeight = 480;

std::string PoseAt(int x_m) {
  return "1 0 0 " + std::to_string(x_m) + "\n0 0 1 0\n0 -1 0 0\n0 0 0 1\n";
}

std::string SegmentPng(std::uint16_t segment) {
  return EncodePixels(Image<std::uint16_t>(kWidth, kHeight, segment), PixelEncoding::kPng);
}

// Writes two frames, listed in reverse order of time: segment 7 of class 3, predicted as 1 of class
// 5.
void WritePanopticRecording(const TemporaryFolder& folder, const std::string& run) {
  for (int i = 0; i < 2; ++i) {
    const std::string stem = run + "/00000" + std::to_string(i);
    WriteTiff(folder.path() / (stem + "_depth.tiff"), Image<float>(kWidth, kHeight, 1.5F));
    folder.Write(stem + "_color.png", EncodeColorPng(Image<Rgb>(kWidth, kHeight)));
    folder.Write(stem + "_segmentation.png", SegmentPng(7));
    folder.Write(stem + "_predicted.png", SegmentPng(1));
    folder.Write(stem + "_labels.json", R"([{"id": 1, "isthing": true, "category_id": 5}])");
    folder.Write(stem + "_pose.txt", PoseAt(i));
  }
  folder.Write(run + "/timestamps.csv",
               "ImageID,TimeStamp\n000001,2000000100\n000000,2000000000\n");
  folder.Write("groundtruth_labels.csv", "InstanceID,ClassID,PanopticID,Name\n7,3,1,SM_Bed\n");
}

int PixelOf(const v1::LabelImage& image) {
  const PixelEncoding encoding =
      image.encoding() == v1::LABEL_ENCODING_PNG ? PixelEncoding::kPng : PixelEncoding::kZstdUint8;
  const auto pixels = DecodePixels(image.data(), encoding, kWidth, kHeight);
  EXPECT_TRUE(pixels.ok()) << pixels.status();
  return pixels.ok() ? pixels->At(100, 200) : -1;
}

TEST(PanopticDataset, FramesComeInTheOrderOfTime) {
  const TemporaryFolder folder;
  WritePanopticRecording(folder, "run1");
  const std::vector<v1::Frame> frames = ReadAll("panoptic", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(TimeOf(frames[0]), 2'000'000'000);
  EXPECT_EQ(TimeOf(frames[1]), 2'000'000'100);
  const v1::Frame& frame = frames[1];
  EXPECT_EQ(frame.world_from_camera().position_m().x(), 1);
  EXPECT_NEAR(frame.world_from_camera().orientation().x(), -0.5 * std::sqrt(2.0), 1e-9);
  EXPECT_EQ(frame.intrinsics().fx(), 320);
  EXPECT_EQ(frame.intrinsics().cy(), 240);
  EXPECT_EQ(frame.color().data(), ContentOf(folder.path() / "run1/000001_color.png"));
  const auto depth = DecodeDepth(frame.depth().data(), PixelEncoding::kZstdUint16, 640, 480);
  ASSERT_TRUE(depth.ok()) << depth.status();
  EXPECT_NEAR(depth->At(639, 479) * frame.depth().metres_per_unit(), 1.5, 1e-12);
}

TEST(PanopticDataset, TrueSegmentsAreInstancesAndTheTableGivesTheirClass) {
  const TemporaryFolder folder;
  WritePanopticRecording(folder, "run1");
  const v1::Frame frame = ReadAll("panoptic", {folder.path() / "run1/"}, {}).at(0);
  EXPECT_EQ(PixelOf(frame.instances()), 7);
  EXPECT_EQ(PixelOf(frame.labels()), 3);
  DatasetOptions options;
  options.label_map_file = folder.Write("map.txt", "3 9\n");
  EXPECT_EQ(PixelOf(ReadAll("panoptic", {folder.path()}, options).at(0).labels()), 9);
}

TEST(PanopticDataset, PredictionStandsInForWhatIsMissingOfTheTruth) {
  const TemporaryFolder folder;
  WritePanopticRecording(folder, "run1");
  fs::remove(folder.path() / "groundtruth_labels.csv");
  const v1::Frame without_table = ReadAll("panoptic", {folder.path()}, {}).at(0);
  EXPECT_EQ(PixelOf(without_table.instances()), 7);
  EXPECT_EQ(PixelOf(without_table.labels()), 5);
  fs::remove(folder.path() / "run1/000000_segmentation.png");
  EXPECT_EQ(PixelOf(ReadAll("panoptic", {folder.path()}, {}).at(0).instances()), 1);
  fs::remove(folder.path() / "run1/000000_labels.json");
  EXPECT_FALSE(ReadAll("panoptic", {folder.path()}, {}).at(0).has_labels());
  fs::remove(folder.path() / "run1/000000_predicted.png");
  EXPECT_FALSE(ReadAll("panoptic", {folder.path()}, {}).at(0).has_instances());
}

TEST(PanopticDataset, PlaysBothRuns) {
  const TemporaryFolder folder;
  WritePanopticRecording(folder, "run2");
  WritePanopticRecording(folder, "run1");
  const std::vector<v1::Frame> frames = ReadAll("panoptic", {folder.path()}, {.stride = 1});
  ASSERT_EQ(frames.size(), 4U);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_GT(TimeOf(frames[i]), TimeOf(frames[i - 1]));
}

TEST(PanopticDataset, FramesWithoutAPoseAreSkippedAndBrokenOnesAreErrors) {
  const TemporaryFolder folder;
  WritePanopticRecording(folder, "run1");
  fs::remove(folder.path() / "run1/000000_pose.txt");
  folder.Write("run1/000001_pose.txt", "1 0 0\n");
  auto source = OpenDataset("panoptic", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->skipped_count(), 1U);
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("000001_pose.txt"));
}

TEST(PanopticDataset, MissingOrBrokenImagesAreErrorsOfTheirFrame) {
  const TemporaryFolder folder;
  WritePanopticRecording(folder, "run1");
  fs::remove(folder.path() / "groundtruth_labels.csv");
  fs::remove(folder.path() / "run1/000000_depth.tiff");
  folder.Write("run1/000001_labels.json", "[{]");
  auto source = OpenDataset("panoptic", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("000000_depth.tiff"));
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("000001_labels.json"));
}

TEST(PanopticDataset, RefusesMalformedTables) {
  struct Case {
    const char* file;
    const char* text;
    const char* where;
  };

  for (const Case& c :
       {Case{"run1/timestamps.csv", "000001\n", "timestamps.csv:1"},
        Case{"run1/timestamps.csv", "ImageID,TimeStamp\n1,x\n", "timestamps.csv:2"},
        Case{"run1/timestamps.csv", "000001,-5\n", "timestamps.csv:1"},
        Case{"run1/timestamps.csv", "000001,1e300\n", "timestamps.csv:1"},
        Case{"run1/timestamps.csv", "../../etc,5\n", "timestamps.csv:1"},
        Case{"run1/timestamps.csv", "ImageID,TimeStamp\n", "run1"},
        Case{"groundtruth_labels.csv", "Name\nbed\n", "groundtruth_labels.csv:1"}}) {
    const TemporaryFolder folder;
    WritePanopticRecording(folder, "run1");
    folder.Write(c.file, c.text);
    const auto source = OpenDataset("panoptic", {folder.path()}, {});
    ASSERT_FALSE(source.ok()) << c.text;
    EXPECT_THAT(std::string(source.status().message()), HasSubstr(c.where));
  }
}

}  // namespace
}  // namespace steadymap
