#include "client/dataset/dataset.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/frame/image_codec.h"
#include "tests/client/dataset/recording_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(OpenDataset, RefusesWhatItCannotOpenAndSaysWhy) {
  const TemporaryFolder folder;
  const auto message = [](std::string_view format,
                          const std::vector<fs::path>& paths,
                          const DatasetOptions& options) {
    const auto source = OpenDataset(format, paths, options);
    EXPECT_FALSE(source.ok());
    return std::string(source.status().message());
  };
  EXPECT_THAT(message("rosbag", {folder.path()}, {}),
              HasSubstr("torwic, seven-scenes, tum, co-fusion, panoptic"));
  EXPECT_THAT(message("tum", {}, {}), HasSubstr("path"));
  EXPECT_THAT(message("tum", {folder.path() / "gone"}, {}), HasSubstr("gone"));
  DatasetOptions no_stride;
  no_stride.stride = 0;
  EXPECT_THAT(message("tum", {folder.path()}, no_stride), HasSubstr("stride"));
  for (const std::string& format : DatasetFormats()) {
    EXPECT_THAT(message(format, {folder.path()}, {}), HasSubstr(folder.path().string())) << format;
    EXPECT_THAT(message(format, {folder.path()}, {}), HasSubstr("expected")) << format;
  }
}

TEST(OpenDataset, GivesEachFrameAgain) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 3});
  const std::vector<v1::Frame> frames = ReadAll("torwic", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 3U);
  const auto source = OpenDataset("torwic", {folder.path()}, {}).value();
  ASSERT_TRUE(source->Next().ok());
  for (const std::size_t index : {2U, 0U, 1U, 0U}) {
    EXPECT_EQ(source->Read(index)->SerializeAsString(), frames[index].SerializeAsString());
  }
  EXPECT_EQ(source->Read(3).status().code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(source->Next().value()->SerializeAsString(), frames[1].SerializeAsString());
}

TEST(OpenDataset, AppliesAnotherWorldFromAFile) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 1});
  DatasetOptions options;
  options.T_world_dataset_file = folder.Write("T.txt", "0 -1 0 10\n1 0 0 20\n0 0 1 30\n0 0 0 1\n");
  const v1::Frame plain = ReadAll("torwic", {folder.path()}, {}).at(0);
  const v1::Frame moved = ReadAll("torwic", {folder.path()}, options).at(0);
  const v1::Vector3& before = plain.world_from_camera().position_m();
  const v1::Vector3& after = moved.world_from_camera().position_m();
  EXPECT_NEAR(after.x(), 10 - before.y(), 1e-12);
  EXPECT_NEAR(after.y(), 20 + before.x(), 1e-12);
  EXPECT_NEAR(after.z(), 30 + before.z(), 1e-12);
}

TEST(OpenDataset, RefusesAWorldThatIsNoRigidTransform) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 1});
  for (const char* text : {"",
                           "1 0 0 0\n0 1 0 0\n0 0 1 0\n",
                           "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n5\n",
                           "1 0 0\n0 1 0\n0 0 1\n0 0 0\n",
                           "2 0 0 0\n0 2 0 0\n0 0 2 0\n0 0 0 1\n",
                           "-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
                           "1 0 0 nan\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
                           "a b c d\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"}) {
    DatasetOptions options;
    options.T_world_dataset_file = folder.Write("T.txt", text);
    const auto source = OpenDataset("torwic", {folder.path()}, options);
    EXPECT_FALSE(source.ok()) << text;
    EXPECT_THAT(std::string(source.status().message()), HasSubstr("T.txt"));
  }
}

TEST(OpenDataset, MapsLabelsAndPacksThemAnew) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 1, .label = 3});
  DatasetOptions options;
  options.label_map_file = folder.Write("map.txt", "# walls\n3 4\n");
  const v1::Frame plain = ReadAll("torwic", {folder.path()}, {}).at(0);
  EXPECT_EQ(plain.labels().encoding(), v1::LABEL_ENCODING_PNG);
  EXPECT_EQ(plain.labels().data(), ContentOf(folder.path() / "sequence/Segmentation/0000.png"));
  const v1::Frame mapped = ReadAll("torwic", {folder.path()}, options).at(0);
  EXPECT_EQ(mapped.labels().encoding(), v1::LABEL_ENCODING_ZSTD_UINT8);
  const auto labels = DecodePixels(mapped.labels().data(), PixelEncoding::kZstdUint8, 640, 360);
  ASSERT_TRUE(labels.ok()) << labels.status();
  EXPECT_EQ(labels->At(7, 9), 4);

  options.label_map_file = folder.Write("wide.txt", "3 4000\n");
  const v1::Frame wide = ReadAll("torwic", {folder.path()}, options).at(0);
  EXPECT_EQ(wide.labels().encoding(), v1::LABEL_ENCODING_ZSTD_UINT16);
}

TEST(OpenDataset, StrideAndColourFollowTheOptions) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 7, .has_color = true});
  DatasetOptions options;
  options.stride = 3;
  options.include_color = false;
  const std::vector<v1::Frame> frames = ReadAll("torwic", {folder.path()}, options);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_FALSE(frames[0].has_color());
  EXPECT_NEAR(frames[2].world_from_camera().position_m().x() -
                  frames[0].world_from_camera().position_m().x(),
              6 * 0.1,
              1e-9);
  EXPECT_TRUE(ReadAll("torwic", {folder.path()}, {}).at(0).has_color());
}

TEST(OpenDataset, PlaysTheSequencesOfAFolderInNaturalOrderWithRisingTimes) {
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "run10", {.frame_count = 2, .x_m = 10});
  WriteTorwicRecording(folder, "run2", {.frame_count = 2, .x_m = 2});
  folder.Write("notes/readme.txt", "no sequence");
  const std::vector<v1::Frame> frames = ReadAll("torwic", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_NEAR(frames[2].world_from_camera().position_m().x() -
                  frames[0].world_from_camera().position_m().x(),
              8,
              1e-9);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    EXPECT_GT(TimeOf(frames[i]), TimeOf(frames[i - 1]));
  }
  EXPECT_EQ(ReadAll("torwic", {folder.path() / "run2", folder.path()}, {}).size(), 6U);
}

TEST(SharedLabelMaps, AreCompleteAndTheAlternateOneIsAPermutation) {
  const fs::path maps = STEADYMAP_LABEL_MAPS;
  const TemporaryFolder folder;
  WriteTorwicRecording(folder, "sequence", {.frame_count = 1, .label = 15});
  DatasetOptions options;
  options.label_map_file = maps / "torwic-table.txt";
  EXPECT_EQ(ReadAll("torwic", {folder.path()}, options).at(0).labels().encoding(),
            v1::LABEL_ENCODING_PNG);
  options.label_map_file = maps / "torwic-alternate.txt";
  const v1::Frame frame = ReadAll("torwic", {folder.path()}, options).at(0);
  const auto labels = DecodePixels(frame.labels().data(), PixelEncoding::kZstdUint8, 640, 360);
  ASSERT_TRUE(labels.ok());
  EXPECT_EQ(labels->At(0, 0), 3);
}

}  // namespace
}  // namespace steadymap
