#include "client/dataset/recording_check.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/dataset/dataset.h"
#include "tests/client/dataset/recording_builder.h"
#include "tests/support/temporary_folder.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string TextOf(const absl::Status& status) { return std::string(status.message()); }

RecordingSample SampleOf(double median_depth_m) {
  return {.frame_count = 3,
          .median_depth_m = median_depth_m,
          .metres_per_unit = 0.001,
          .first_time = Timestamp::FromSeconds(1.6e9)};
}

TEST(CheckDepth, TakesWhatARobotMaySee) {
  for (const double median_m : {0.05, 0.3, 2.0, 100.0}) {
    EXPECT_TRUE(CheckDepth(SampleOf(median_m), true).ok()) << median_m;
  }
}

TEST(CheckDepth, RefusesAWrongUnitAndSaysHowToNameTheRightOne) {
  for (const double median_m : {0.0004, 0.0499, 100.1, 2000.0}) {
    const absl::Status status = CheckDepth(SampleOf(median_m), true);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << median_m;
    EXPECT_THAT(TextOf(status), HasSubstr("read at 0.001 m per unit"));
    EXPECT_THAT(TextOf(status), HasSubstr("--depth-scale"));
  }
}

TEST(CheckDepth, NamesNoOptionWhereTheFormatHasNone) {
  const std::string text = TextOf(CheckDepth(SampleOf(0.001), false));
  EXPECT_THAT(text, HasSubstr("hold metres"));
  EXPECT_THAT(text, Not(HasSubstr("--depth-scale")));
}

TEST(CheckDepth, RefusesDepthThatIsNowhereValid) {
  RecordingSample sample = SampleOf(1.0);
  sample.median_depth_m.reset();
  EXPECT_THAT(TextOf(CheckDepth(sample, true)), HasSubstr("no pixel of the 3 sampled frames"));
  EXPECT_FALSE(CheckDepth(sample, false).ok());
}

TEST(CheckDepth, SaysNothingOfFramesThatCannotBeRead) {
  EXPECT_TRUE(CheckDepth(RecordingSample(), true).ok());
}

TEST(NoteOnTimes, WarnsOfClocksThatWereNeverSet) {
  RecordingSample sample = SampleOf(1.0);
  EXPECT_FALSE(NoteOnTimes(sample).has_value());
  sample.first_time = Timestamp::FromSeconds(946'684'800.0);
  EXPECT_FALSE(NoteOnTimes(sample).has_value());
  sample.first_time = Timestamp::FromSeconds(946'684'799.0);
  EXPECT_THAT(NoteOnTimes(sample).value_or(""), HasSubstr("1999-12-31T23:59:59Z"));
}

/// Writes frames of 320 x 240 pixels in the TUM layout, each with a constant depth.
void WriteDepths(const TemporaryFolder& folder, const std::vector<std::uint16_t>& units) {
  std::string depth;
  std::string poses;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const std::string name = "depth/" + std::to_string(i) + ".png";
    folder.Write(name, DepthPng(320, 240, units[i]));
    depth += std::to_string(1'305'031'102 + i) + " " + name + "\n";
    poses += std::to_string(1'305'031'102 + i) + " 0 0 0 0 0 0 1\n";
  }
  folder.Write("depth.txt", depth);
  folder.Write("groundtruth.txt", poses);
}

constexpr std::array<double, 4> kIntrinsics = {262.5, 262.5, 159.5, 119.5};

TEST(RecordingSample, IsTheMedianOfAllFramesLookedAt) {
  const TemporaryFolder folder;
  WriteDepths(folder, {1000, 0, 3000, 65535, 3000, 4000});
  const auto source = OpenDataset("tum", {folder.path()}, {.intrinsics = kIntrinsics});
  ASSERT_TRUE(source.ok()) << source.status();
  const RecordingSample sample = (*source)->Sample(100);
  EXPECT_EQ(sample.frame_count, 6U);
  ASSERT_TRUE(sample.median_depth_m.has_value());
  EXPECT_NEAR(*sample.median_depth_m, 0.6, 1e-6);
  EXPECT_EQ(sample.metres_per_unit, 0.0002);
  EXPECT_EQ(sample.first_time, Timestamp::FromSeconds(1'305'031'102.0));
  // The first and the last frame.
  EXPECT_EQ((*source)->Sample(2).frame_count, 2U);
  EXPECT_NEAR((*source)->Sample(2).median_depth_m.value_or(0.0), 0.8, 1e-6);
  EXPECT_TRUE((*source)->Next()->has_value()) << "the first frame is still to be delivered";
}

TEST(RecordingSample, PassesOverFramesThatCannotBeRead) {
  const TemporaryFolder folder;
  WriteDepths(folder, {1000, 1000});
  folder.Write("depth/1.png", "no image");
  const auto source = OpenDataset("tum", {folder.path()}, {.intrinsics = kIntrinsics});
  ASSERT_TRUE(source.ok()) << source.status();
  EXPECT_EQ((*source)->Sample(9).frame_count, 1U);
}

TEST(DatasetOptions, TheDepthScaleAndTheIntrinsicsOfTheUserCount) {
  const TemporaryFolder folder;
  WriteDepths(folder, {1000});
  const std::vector<v1::Frame> frames =
      ReadAll("tum", {folder.path()}, {.metres_per_unit = 0.001, .intrinsics = kIntrinsics});
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].depth().metres_per_unit(), 0.001);
  EXPECT_EQ(frames[0].intrinsics().width_px(), 320U);
  EXPECT_EQ(frames[0].intrinsics().height_px(), 240U);
  EXPECT_EQ(frames[0].intrinsics().fx(), 262.5);
  EXPECT_EQ(frames[0].intrinsics().cy(), 119.5);
}

TEST(DatasetOptions, ThoseThatMakeNoSenseAreErrors) {
  const TemporaryFolder folder;
  WriteDepths(folder, {1000});
  const auto error_of = [&](const char* format, const DatasetOptions& options) {
    const auto source = OpenDataset(format, {folder.path()}, options);
    EXPECT_EQ(source.status().code(), absl::StatusCode::kInvalidArgument);
    return TextOf(source.status());
  };
  EXPECT_THAT(error_of("tum", {.metres_per_unit = 5000.0}), HasSubstr("[1e-6, 0.1]"));
  EXPECT_THAT(error_of("tum", {.metres_per_unit = 0.0}), HasSubstr("got 0"));
  EXPECT_THAT(error_of("tum", {.intrinsics = {{-1.0, 1.0, 1.0, 1.0}}}), HasSubstr("320 x 240"));
  EXPECT_THAT(error_of("co-fusion", {.metres_per_unit = 0.001}), HasSubstr("in metres"));
  EXPECT_THAT(error_of("panoptic", {.intrinsics = kIntrinsics}), HasSubstr("in metres"));
}

TEST(HasDepthUnit, IsFalseWhereFilesHoldMetres) {
  EXPECT_TRUE(HasDepthUnit("torwic"));
  EXPECT_TRUE(HasDepthUnit("seven-scenes"));
  EXPECT_TRUE(HasDepthUnit("tum"));
  EXPECT_FALSE(HasDepthUnit("co-fusion"));
  EXPECT_FALSE(HasDepthUnit("panoptic"));
  EXPECT_FALSE(HasDepthUnit("kitti"));
}

}  // namespace
}  // namespace steadymap
