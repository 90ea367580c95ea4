#include "core/association/observation.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_samples.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::SamplesOf;
using ::steadymap::testing::Scene;

/// Returns an association without owners.
Association NoOwners(const SampleGrid& samples) {
  Association association;
  association.owner.assign(samples.size(), Association::kNone);
  return association;
}

std::size_t CountValid(const SampleGrid& samples) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) count += samples[i].is_valid() ? 1U : 0U;
  return count;
}

/// Returns a frame of a wall at 2 m that fills the image: goods to the left, wall to the right.
Frame HalfAndHalf() {
  return RenderScene({Body(kGoodsClass, {2.0, 0.0, -4.0}, {2.3, 4.0, 4.0}),
                      Body(kWallClass, {2.0, -4.0, -4.0}, {2.3, 0.0, 4.0})},
                     {});
}

TEST(FindObservations, GroupsConnectedSurfaceOfOneClass) {
  const SampleGrid samples = SamplesOf(HalfAndHalf());
  const std::vector<Observation> found = FindObservations(samples, NoOwners(samples));
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].label, kGoodsClass);
  EXPECT_EQ(found[1].label, kWallClass);
  EXPECT_EQ(found[0].samples.size() + found[1].samples.size(), CountValid(samples));
  // The image spans 320 / 277 by 240 / 277 of the depth. Towards the corners, the estimated area of
  // a sample is slightly larger than its true area.
  const double picture_m2 = 4.0 * 320.0 * 240.0 / (277.0 * 277.0);
  const double found_m2 = found[0].area_m2 + found[1].area_m2;
  EXPECT_GT(found_m2, 0.95 * picture_m2);
  EXPECT_LT(found_m2, 1.15 * picture_m2);
}

TEST(FindObservations, HoldsNoSampleTwice) {
  const SampleGrid samples = SamplesOf(HalfAndHalf());
  std::set<std::size_t> seen;
  for (const Observation& observation : FindObservations(samples, NoOwners(samples))) {
    EXPECT_FALSE(observation.samples.empty());
    for (const std::size_t index : observation.samples) {
      EXPECT_TRUE(seen.insert(index).second);
      EXPECT_EQ(samples[index].label, observation.label);
    }
  }
}

TEST(FindObservations, SeparatesThingsOfOneClassThatStandApart) {
  const Scene scene = {Body(kGoodsClass, {1.5, -0.6, -0.3}, {1.9, -0.2, 0.3}),
                       Body(kGoodsClass, {1.5, 0.2, -0.3}, {1.9, 0.6, 0.3}),
                       Body(kGoodsClass, {2.6, -4.0, -4.0}, {2.9, 4.0, 4.0})};
  const SampleGrid samples = SamplesOf(RenderScene(scene, {}));
  EXPECT_EQ(FindObservations(samples, NoOwners(samples)).size(), 3U);
}

TEST(FindObservations, AreTheLargestOfTooMany) {
  Frame frame = HalfAndHalf();
  const PinholeCamera& camera = frame.camera;
  frame.instances = Image<std::uint16_t>(camera.width_px, camera.height_px);
  // One instance of four by four samples among instances of one sample, more than the limit per
  // frame.
  constexpr int kSamplePx = 4;
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const int column = u / kSamplePx;
      const int row = v / kSamplePx;
      const bool is_large = column >= 60 && column < 64 && row >= 50 && row < 54;
      frame.instances.At(u, v) =
          static_cast<std::uint16_t>(is_large ? 1 : row * camera.width_px + column + 2);
    }
  }
  const SampleGrid samples = SamplesOf(frame);
  ASSERT_GT(CountValid(samples), 2 * kMaxObservations);
  const std::vector<Observation> found = FindObservations(samples, NoOwners(samples));
  ASSERT_EQ(found.size(), kMaxObservations);
  // The large observation begins low in the image, after the smaller ones that are kept.
  EXPECT_EQ(found.back().samples.size(), 16U);
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_LT(found[i - 1].samples.front(), found[i].samples.front());
  }
}

TEST(FindObservations, GroupsByInstanceWhereThereIsOne) {
  Frame frame = HalfAndHalf();
  frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px, 5);
  const SampleGrid samples = SamplesOf(frame);
  const std::vector<Observation> whole = FindObservations(samples, NoOwners(samples));
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].instance, 5);

  for (int v = 0; v < frame.camera.height_px / 2; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) frame.instances.At(u, v) = 6;
  }
  const SampleGrid halves = SamplesOf(frame);
  EXPECT_EQ(FindObservations(halves, NoOwners(halves)).size(), 2U);
}

TEST(FindObservations, LeavesOutWhatIsOwned) {
  const SampleGrid samples = SamplesOf(HalfAndHalf());
  Association association = NoOwners(samples);
  for (int row = 0; row < samples.height(); ++row) {
    for (int column = 0; column < samples.width(); ++column) {
      const std::size_t index = samples.Index(column, row);
      if (samples[index].label != kWallClass) continue;
      association.owner[index] = row < samples.height() / 4 ? kBackgroundOwner : 3;
    }
  }
  const std::vector<Observation> found = FindObservations(samples, association);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].label, kGoodsClass);
}

TEST(FindObservations, FindsNothingWithoutReturns) {
  const SampleGrid samples = SamplesOf(RenderScene({}, {}));
  EXPECT_TRUE(FindObservations(samples, NoOwners(samples)).empty());
}

}  // namespace
}  // namespace steadymap
