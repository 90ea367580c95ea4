#include "core/types/map_config.h"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/types/error.h"

namespace steadymap {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

TEST(ValidateMapConfig, TakesTheDefaultsAndTheLimits) {
  EXPECT_TRUE(ValidateMapConfig(MapConfig()).ok());
  for (const double voxel_size_m : {0.001, 0.02, 1.0}) {
    for (const double truncation_voxels : {2.0, 3.0, 16.0}) {
      MapConfig config;
      config.voxel_size_m = voxel_size_m;
      config.truncation_m = truncation_voxels * voxel_size_m;
      EXPECT_TRUE(ValidateMapConfig(config).ok()) << voxel_size_m << ", " << truncation_voxels;
    }
  }
}

TEST(ValidateMapConfig, ReportsAllViolationsAndTheFirstField) {
  MapConfig config;
  config.truncation_m = 1.0;
  config.max_depth_m = std::nan("");
  config.classes[3].id = config.classes[2].id;
  config.classes[4].name.clear();
  const absl::Status status = ValidateMapConfig(config);
  EXPECT_EQ(ReasonOf(status), reason::kBadValue);
  EXPECT_EQ(FieldOf(status), "truncation_m");
  EXPECT_THAT(MessageOf(status), HasSubstr("truncation_m must lie in [0.1, 0.8], got 1"));
  EXPECT_THAT(MessageOf(status), HasSubstr("max_depth_m must lie in [0.1, 100], got nan"));
  EXPECT_THAT(MessageOf(status), HasSubstr("classes[3].id 2 is a duplicate"));
  EXPECT_THAT(MessageOf(status), HasSubstr("classes[4].name must have 1 to 64 bytes, got 0"));
}

TEST(ValidateMapConfig, DoesNotMeasureTheTruncationByImpossibleVoxels) {
  for (const double voxel_size_m : {-0.02, 0.0, 1e9, std::nan("")}) {
    MapConfig config;
    config.voxel_size_m = voxel_size_m;
    const absl::Status status = ValidateMapConfig(config);
    EXPECT_EQ(FieldOf(status), "voxel_size_m");
    EXPECT_THAT(MessageOf(status), Not(HasSubstr("truncation_m")));
  }
}

TEST(ValidateMapConfig, TakesOnlyParametersOfThePolicyWithinTheirRange) {
  MapConfig config;
  config.policy = UpdatePolicy::kPocdPaper;
  config.parameters = {{"change_noise_m", 0.03}, {"max_dissimilarity", 1.0}};
  EXPECT_TRUE(ValidateMapConfig(config).ok());
  for (const double value : {-0.1, 11.0, std::nan(""), HUGE_VAL}) {
    config.parameters = {{"change_noise_m", value}};
    EXPECT_EQ(FieldOf(ValidateMapConfig(config)), "parameters[change_noise_m]") << value;
  }
  EXPECT_THAT(MessageOf(ValidateMapConfig(config)), HasSubstr("must lie in [0.001, 10], got inf"));
  config.parameters = {{"max_jump_m", 0.1}};
  EXPECT_THAT(MessageOf(ValidateMapConfig(config)),
              HasSubstr("is not a parameter of the policy, which has: association_distance_m, "));
  config.policy = UpdatePolicy::kTracking;
  EXPECT_TRUE(ValidateMapConfig(config).ok());
  config.parameters = {{"min_samples", 4.5}};
  EXPECT_THAT(MessageOf(ValidateMapConfig(config)), HasSubstr("must be a whole number, got 4.5"));
}

TEST(ValidateMapConfig, AnEndlessNameOfAParameterGivesAShortMessage) {
  MapConfig config;
  config.parameters = {{std::string(1'000'000, 'x'), 1.0}};
  const absl::Status status = ValidateMapConfig(config);
  EXPECT_EQ(ReasonOf(status), reason::kBadValue);
  EXPECT_LT(status.message().size(), 400U);
  EXPECT_LT(FieldOf(status).size(), 100U);
}

TEST(ValidateMapConfig, NeedsClasses) {
  MapConfig config;
  config.classes.clear();
  EXPECT_EQ(FieldOf(ValidateMapConfig(config)), "classes");
}

TEST(ValidateMapConfig, NamesTheFirstOfVeryManyViolations) {
  MapConfig config;
  config.classes.assign(1000, {ClassId(1), "twice", ClassMotion::kStatic});
  const std::string message = MessageOf(ValidateMapConfig(config));
  EXPECT_THAT(message, HasSubstr("classes[1].id 1 is a duplicate"));
  EXPECT_THAT(message, HasSubstr("; and 989 more"));
  EXPECT_LT(message.size(), 1000U);
}

TEST(MapConfig, LabelLimitIsBehindTheLargestClass) {
  MapConfig config;
  EXPECT_EQ(config.label_limit(), 16U);
  config.classes = {{ClassId(65535), "everything", ClassMotion::kStatic}};
  EXPECT_EQ(config.label_limit(), 65536U);
}

}  // namespace
}  // namespace steadymap
