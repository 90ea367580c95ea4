#include "core/association/ground.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_samples.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::SamplesOf;
using ::steadymap::testing::SceneLook;

constexpr std::uint16_t kGroundClass = 1;
constexpr double kGroundM = 0.13;

testing::SceneBody Ground() {
  return Body(kGroundClass, {-5.0, -5.0, kGroundM - 0.5}, {9.0, 5.0, kGroundM});
}

/// Returns a crate on the ground, 1 m wide and 0.5 m high.
testing::SceneBody CrateOnGround() {
  return Body(kGoodsClass, {1.5, -0.5, kGroundM}, {2.2, 0.5, kGroundM + 0.5});
}

SceneLook FromAbove() {
  return {.eye_world = {0.0, 0.0, kGroundM + 1.2}, .target_world = {1.8, 0.0, kGroundM + 0.2}};
}

TEST(FindGroundHeight, FindsTheFloorBelowThings) {
  const SampleGrid samples = SamplesOf({Ground(), CrateOnGround()}, FromAbove());
  const std::optional<double> height_m = FindGroundHeight(samples, kGroundM + 1.2);
  ASSERT_TRUE(height_m.has_value());
  EXPECT_NEAR(*height_m, kGroundM, 0.03);
}

TEST(FindGroundHeight, FindsNoneOnAWall) {
  const SampleGrid samples = SamplesOf({Body(4, {2.0, -4.0, -4.0}, {2.3, 4.0, 4.0})}, {});
  EXPECT_EQ(FindGroundHeight(samples, 0.0), std::nullopt);
}

TEST(FindGroundHeight, TakesNoTablesTopWhereSomethingIsSeenBelowIt) {
  // The floor is outside the image. The crate is beside the table.
  const testing::SceneBody top = Body(8, {1.0, -0.6, kGroundM + 0.7}, {2.4, 0.6, kGroundM + 0.75});
  const testing::SceneBody crate =
      Body(kGoodsClass, {1.4, 0.7, kGroundM + 0.1}, {2.0, 1.3, kGroundM + 0.8});
  const SceneLook look{.eye_world = {0.0, 0.0, kGroundM + 1.2},
                       .target_world = {1.6, 0.4, kGroundM + 0.6}};
  EXPECT_EQ(FindGroundHeight(SamplesOf({top, crate}, look), kGroundM + 1.2), std::nullopt);
  const std::optional<double> height_m =
      FindGroundHeight(SamplesOf({top, crate, Ground()}, look), kGroundM + 1.2);
  ASSERT_TRUE(height_m.has_value()) << "the floor is in the picture now";
  EXPECT_NEAR(*height_m, kGroundM, 0.03);
}

TEST(FindGroundHeight, FindsNoneAboveTheCamera) {
  const SampleGrid samples = SamplesOf({Ground()}, FromAbove());
  EXPECT_EQ(FindGroundHeight(samples, kGroundM + 0.05), std::nullopt);
}

TEST(FindGroundHeight, FindsNoneWithoutSamples) {
  EXPECT_EQ(FindGroundHeight(SampleGrid(), 1.0), std::nullopt);
}

TEST(AssignGround, GivesTheFloorAndNothingElseToTheBackground) {
  const SampleGrid samples = SamplesOf({Ground(), CrateOnGround()}, FromAbove());
  Association association;
  association.owner.assign(samples.size(), Association::kNone);
  AssignGround(samples, kGroundM, &association);
  std::size_t of_crate = 0;
  for (std::size_t index = 0; index < samples.size(); ++index) {
    if (!samples[index].is_valid()) continue;
    const double height_m = static_cast<double>(samples[index].position_world.z()) - kGroundM;
    if (height_m > 0.1) {
      EXPECT_EQ(association.owner[index], Association::kNone) << height_m;
      ++of_crate;
    } else if (height_m < 0.01) {
      EXPECT_EQ(association.owner[index], kBackgroundOwner) << height_m;
    }
  }
  EXPECT_GT(of_crate, 100U);
}

}  // namespace
}  // namespace steadymap
