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

// Writes three depth images; colour images and poses have slightly different times.
void WriteTumRecording(const TemporaryFolder& folder) {
  for (const char* name : {"a", "b", "c"}) {
    folder.Write(std::string("depth/") + name + ".png", DepthPng(640, 480, 5000));
    folder.Write(std::string("rgb/") + name + ".png", EncodeColorPng(Image<Rgb>(640, 480)));
  }
  folder.Write("depth.txt",
               "# depth maps\n1305031102.160407 depth/a.png\n1305031102.194330 depth/b.png\n"
               "1305031102.300000 depth/c.png\n");
  folder.Write("rgb.txt", "1305031102.175304 rgb/a.png\n1305031102.250000 rgb/b.png\n");
  folder.Write("groundtruth.txt",
               "1305031102.150000 1 2 3 0 0 0 1\n1305031102.200000 4 5 6 0 0 0 1\n"
               "1305031102.330000 7 8 9 0 0 0 1\n");
}

TEST(TumDataset, AssociatesWithinTwentyMilliseconds) {
  const TemporaryFolder folder;
  WriteTumRecording(folder);
  auto source = OpenDataset("tum", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  // c: the nearest pose is 30 ms away.
  EXPECT_EQ((*source)->skipped_count(), 1U);
  const std::vector<v1::Frame> frames = ReadAll("tum", {folder.path()}, {});
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(TimeOf(frames[0]), 1'305'031'102'160'407'000);
  EXPECT_EQ(frames[0].world_from_camera().position_m().x(), 1);
  EXPECT_EQ(frames[1].world_from_camera().position_m().x(), 4);
  EXPECT_TRUE(frames[0].has_color());  // 15 ms away.
  EXPECT_TRUE(frames[1].has_color());  // 19 ms away, the same image.
  EXPECT_DOUBLE_EQ(frames[0].depth().metres_per_unit(), 0.0002);
  EXPECT_EQ(frames[0].intrinsics().fx(), 525);
  EXPECT_EQ(frames[0].depth().data(), ContentOf(folder.path() / "depth/a.png"));
}

TEST(TumDataset, LoadsWithoutColour) {
  const TemporaryFolder folder;
  WriteTumRecording(folder);
  fs::remove(folder.path() / "rgb.txt");
  EXPECT_FALSE(ReadAll("tum", {folder.path()}, {}).at(0).has_color());
}

TEST(TumDataset, PosesThatAreNotFiniteAreLeftOut) {
  const TemporaryFolder folder;
  WriteTumRecording(folder);
  folder.Write("groundtruth.txt",
               "1305031102.160000 nan 2 3 0 0 0 1\n1305031102.200000 4 5 6 0 0 0 1\n");
  auto source = OpenDataset("tum", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->frame_count(), 1U);
  EXPECT_EQ((*source)->skipped_count(), 2U);
}

TEST(TumDataset, RefusesListsThatAreMissingOrMalformed) {
  struct Case {
    const char* file;
    const char* text;  // Null: removed.
  };

  for (const Case& c : {Case{"groundtruth.txt", nullptr},
                        Case{"groundtruth.txt", "1305031102.16 1 2 3\n"},
                        Case{"groundtruth.txt", "soon 1 2 3 0 0 0 1\n"},
                        Case{"groundtruth.txt", "1e300 1 2 3 0 0 0 1\n"},
                        Case{"depth.txt", "1305031102.16\n"},
                        Case{"depth.txt", "-1 depth/a.png\n"},
                        Case{"depth.txt", "nan depth/a.png\n"},
                        Case{"rgb.txt", "x y z\n"}}) {
    const TemporaryFolder folder;
    WriteTumRecording(folder);
    if (c.text != nullptr) {
      folder.Write(c.file, c.text);
    } else {
      fs::remove(folder.path() / c.file);
    }
    const auto source = OpenDataset("tum", {folder.path()}, {});
    ASSERT_FALSE(source.ok()) << c.file;
    EXPECT_THAT(std::string(source.status().message()), HasSubstr(c.file));
  }
}

TEST(TumDataset, EmptyListsAndMissingImagesAreErrors) {
  const TemporaryFolder folder;
  WriteTumRecording(folder);
  fs::remove(folder.path() / "depth/a.png");
  auto source = OpenDataset("tum", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("depth/a.png"));
  EXPECT_TRUE((*source)->Next().ok());
  folder.Write("depth.txt", "# none\n");
  EXPECT_FALSE(OpenDataset("tum", {folder.path()}, {}).ok());
}

TEST(TumDataset, BrokenRotationIsAnErrorOfItsFrame) {
  const TemporaryFolder folder;
  WriteTumRecording(folder);
  folder.Write("groundtruth.txt", "1305031102.160000 1 2 3 0 0 0 5\n");
  auto source = OpenDataset("tum", {folder.path()}, {});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_THAT(std::string((*source)->Next().status().message()), HasSubstr("groundtruth.txt:1"));
}

}  // namespace
}  // namespace steadymap
