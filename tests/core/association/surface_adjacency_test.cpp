#include "core/association/surface_adjacency.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_samples.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::SamplesOf;
using ::steadymap::testing::Scene;

/// Assigns samples left of the image centre to `left`, and the others to `right`.
Association Halves(const SampleGrid& samples, std::uint32_t left, std::uint32_t right) {
  Association association;
  association.owner.assign(samples.size(), Association::kNone);
  for (int row = 0; row < samples.height(); ++row) {
    for (int column = 0; column < samples.width(); ++column) {
      association.owner[samples.Index(column, row)] = column < samples.width() / 2 ? left : right;
    }
  }
  return association;
}

Scene OneWall() { return {Body(4, {2.0, -4.0, -4.0}, {2.3, 4.0, 4.0})}; }

TEST(FindSurfaceAdjacencies, CountsThePairsAlongACommonBorder) {
  const SampleGrid samples = SamplesOf(OneWall(), {});
  const std::vector<Contact> contacts = FindSurfaceAdjacencies(samples, Halves(samples, 7, 2));
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].first, 2U);
  EXPECT_EQ(contacts[0].second, 7U);
  // One pair per row. The outermost rows may be invalid.
  EXPECT_GE(contacts[0].samples, static_cast<std::size_t>(samples.height() - 4));
  EXPECT_LE(contacts[0].samples, static_cast<std::size_t>(samples.height()));
}

TEST(FindSurfaceAdjacencies, FindsNoneAcrossADepthEdge) {
  const Scene step = {Body(4, {1.5, 0.0, -4.0}, {1.8, 4.0, 4.0}),
                      Body(4, {2.5, -4.0, -4.0}, {2.8, 4.0, 4.0})};
  const SampleGrid samples = SamplesOf(step, {});
  EXPECT_TRUE(FindSurfaceAdjacencies(samples, Halves(samples, 1, 2)).empty());
}

TEST(FindSurfaceAdjacencies, FindsNoneBetweenWhatInstanceIdsTellApart) {
  Frame frame = RenderScene(OneWall(), {});
  frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px);
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      // The border of the owners is beside the border of the instances, as for touching objects.
      frame.instances.At(u, v) = u < frame.camera.width_px / 3 ? 3 : 0;
    }
  }
  const SampleGrid samples = SamplesOf(frame);
  EXPECT_TRUE(FindSurfaceAdjacencies(samples, Halves(samples, 1, 2)).empty());
}

TEST(FindSurfaceAdjacencies, LeavesOutBackgroundAndWhatNobodyOwns) {
  const SampleGrid samples = SamplesOf(OneWall(), {});
  EXPECT_TRUE(FindSurfaceAdjacencies(samples, Halves(samples, kBackgroundOwner, 1)).empty());
  EXPECT_TRUE(FindSurfaceAdjacencies(samples, Halves(samples, Association::kNone, 1)).empty());
  EXPECT_TRUE(FindSurfaceAdjacencies(samples, Halves(samples, 1, 1)).empty());
}

}  // namespace
}  // namespace steadymap
