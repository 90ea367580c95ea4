// Frames of scenes with known planes and clusters.

#include "core/association/clusters.h"

#include <algorithm>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "tests/support/analytic_samples.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::SamplesOf;
using ::steadymap::testing::Scene;

constexpr std::uint16_t kRackClass = 6;

/// A frame divided into clusters.
struct Division {
  explicit Division(const Frame& frame, const ClusterParameters& parameters = {})
      : samples(SamplesOf(frame)),
        clusters(FindClusters(
            samples, MapConfig(), frame.T_world_camera.translation(), parameters, &association)) {}

  /// Returns the number of samples within a box that have a given owner.
  std::size_t CountOwned(std::uint32_t owner, const Box& box_world) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const bool is_inside = box_world.contains(samples[i].position_world.cast<double>());
      if (samples[i].is_valid() && is_inside && association.owner[i] == owner) ++count;
    }
    return count;
  }

  std::size_t CountLabel(std::uint16_t label) const {
    return static_cast<std::size_t>(
        std::count_if(clusters.begin(), clusters.end(), [label](const Observation& cluster) {
          return cluster.label == label;
        }));
  }

  SampleGrid samples;
  Association association;
  std::vector<Observation> clusters;
};

/// Sets the label of a share of all pixels, at random.
void AddLabelNoise(double share, std::uint16_t label, Frame* frame) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (std::size_t i = 0; i < frame->labels.size(); ++i) {
    if (uniform(random) < share) frame->labels.data()[i] = label;
  }
}

TEST(FindClusters, LeavesGroundAndCeilingToTheBackgroundWhateverTheirLabels) {
  const Division division(RenderScene({Body(kWallClass, {0.5, -4.0, -1.3}, {6.0, 4.0, -1.0}),
                                       Body(kWallClass, {0.5, -4.0, 1.0}, {6.0, 4.0, 1.3}),
                                       Body(kGoodsClass, {2.0, -0.3, -0.4}, {2.5, 0.3, 0.4})},
                                      {}));
  const Box ground(Eigen::Vector3d(0.5, -4.0, -1.1), Eigen::Vector3d(6.0, 4.0, -0.9));
  const Box ceiling(Eigen::Vector3d(0.5, -4.0, 0.9), Eigen::Vector3d(6.0, 4.0, 1.1));
  EXPECT_GT(division.CountOwned(kBackgroundOwner, ground), 300U);
  EXPECT_GT(division.CountOwned(kBackgroundOwner, ceiling), 300U);
  EXPECT_LT(division.CountOwned(Association::kNone, ceiling), 20U);
  ASSERT_EQ(division.clusters.size(), 1U);
  EXPECT_EQ(division.clusters[0].label, kGoodsClass);
}

TEST(FindClusters, GivesThePointsOfAPlaneTheClassOfMostOfThem) {
  Frame frame = RenderScene({Body(kWallClass, {2.5, -4.0, -4.0}, {2.8, 4.0, 4.0})}, {});
  // Half of the wall, so that smoothing over neighbours does not help.
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px * 2 / 5; ++u) frame.labels.At(u, v) = kGoodsClass;
  }
  const Division division(frame);
  ASSERT_EQ(division.clusters.size(), 1U);
  EXPECT_EQ(division.clusters[0].label, kWallClass);

  // Of a plane that is too small, each point keeps its class.
  ClusterParameters no_planes;
  no_planes.min_plane_samples = 1'000'000;
  EXPECT_EQ(Division(frame, no_planes).clusters.size(), 2U);
}

TEST(FindClusters, GivesACrossingSurfaceNothingOfAPlane) {
  // The wall's plane cuts the far end of the box's side.
  const Division division(RenderScene({Body(kWallClass, {2.5, -4.0, -4.0}, {2.8, 4.0, 4.0}),
                                       Body(kGoodsClass, {1.5, 0.2, -0.3}, {2.5, 0.8, 0.3})},
                                      {{0.5, -1.2, 0.0}, {2.0, 0.2, 0.0}}));
  EXPECT_GE(division.CountLabel(kWallClass), 1U);
  ASSERT_EQ(division.CountLabel(kGoodsClass), 1U);
  const auto goods = std::find_if(
      division.clusters.begin(), division.clusters.end(), [](const Observation& cluster) {
        return cluster.label == kGoodsClass;
      });
  float nearest_m = 10.0F;
  float farthest_m = 0.0F;
  for (const std::size_t index : goods->samples) {
    nearest_m = std::min(nearest_m, division.samples[index].position_world.x());
    farthest_m = std::max(farthest_m, division.samples[index].position_world.x());
  }
  EXPECT_LT(nearest_m, 1.55F);
  EXPECT_GT(farthest_m, 2.4F) << "the side of the box up to the wall";
}

TEST(FindClusters, ClustersByDistanceAndClass) {
  const auto goods = [](double gap_m) {
    return Division(RenderScene({Body(kGoodsClass, {1.5, -0.6, -0.3}, {1.9, -0.5 * gap_m, 0.3}),
                                 Body(kGoodsClass, {1.5, 0.5 * gap_m, -0.3}, {1.9, 0.6, 0.3})},
                                {}))
        .clusters.size();
  };
  EXPECT_EQ(goods(0.3), 2U);
  EXPECT_EQ(goods(0.05), 1U) << "nearer than the cluster distance";
  ClusterParameters parameters;
  parameters.min_plane_samples = 1'000'000;  // The fronts are in one plane.
  const Division classes(RenderScene({Body(kGoodsClass, {1.5, -0.6, -0.3}, {1.9, 0.0, 0.3}),
                                      Body(kRackClass, {1.5, 0.0, -0.3}, {1.9, 0.6, 0.3})},
                                     {}),
                         parameters);
  EXPECT_EQ(classes.CountLabel(kGoodsClass), 1U);
  EXPECT_EQ(classes.CountLabel(kRackClass), 1U);
}

TEST(FindClusters, TakesSmallClustersForOutliers) {
  const Frame frame = RenderScene({Body(kGoodsClass, {1.5, -0.3, -0.3}, {1.9, 0.3, 0.3}),
                                   Body(kGoodsClass, {1.5, 0.8, -0.03}, {1.56, 0.84, 0.03})},
                                  {});
  const Division division(frame);
  EXPECT_EQ(division.clusters.size(), 1U);
  ClusterParameters all;
  all.min_cluster_samples = 1;
  EXPECT_EQ(Division(frame, all).clusters.size(), 2U);
}

TEST(FindClusters, MergesOverlappingCuboids) {
  // A box on a board between two posts: its cuboid is within that of the rack.
  const Frame frame = RenderScene({Body(kRackClass, {1.8, -0.8, -0.5}, {2.3, -0.6, 0.5}),
                                   Body(kRackClass, {1.8, 0.6, -0.5}, {2.3, 0.8, 0.5}),
                                   Body(kRackClass, {1.8, -0.8, -0.5}, {2.3, 0.8, -0.3}),
                                   Body(kGoodsClass, {1.95, -0.2, -0.3}, {2.25, 0.2, 0.1})},
                                  {});
  ClusterParameters parameters;
  parameters.min_plane_samples = 1'000'000;
  const Division merged(frame, parameters);
  ASSERT_EQ(merged.clusters.size(), 1U);
  EXPECT_EQ(merged.clusters[0].label, kRackClass) << "the class of most samples";

  // A box beside the rack stays by itself.
  const Division apart(RenderScene({Body(kRackClass, {1.8, -0.8, -0.5}, {2.3, -0.3, 0.5}),
                                    Body(kGoodsClass, {1.95, 0.2, -0.3}, {2.25, 0.6, 0.1})},
                                   {}),
                       parameters);
  EXPECT_EQ(apart.clusters.size(), 2U);
}

TEST(FindClusters, TakesInstancesForClusters) {
  Frame frame = RenderScene({Body(kGoodsClass, {1.5, -0.6, -0.3}, {1.9, 0.6, 0.3})}, {});
  frame.instances = Image<std::uint16_t>(frame.camera.width_px, frame.camera.height_px, 3);
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px / 2; ++u) frame.instances.At(u, v) = 2;
  }
  const Division division(frame);
  ASSERT_EQ(division.clusters.size(), 2U);
  EXPECT_EQ(division.clusters[0].instance, 2);
  EXPECT_EQ(division.clusters[1].instance, 3);
  EXPECT_EQ(division.clusters[0].label, kGoodsClass);
}

TEST(FindClusters, GivesEachSampleToOneClusterAndEqualFramesEqualClusters) {
  Frame frame = RenderScene({Body(kWallClass, {2.5, -4.0, -4.0}, {2.8, 4.0, 4.0}),
                             Body(kGoodsClass, {1.5, -0.6, -0.3}, {1.9, -0.2, 0.3}),
                             Body(kRackClass, {1.5, 0.2, -0.3}, {1.9, 0.6, 0.3})},
                            {});
  AddLabelNoise(0.3, kRackClass, &frame);
  const Division first(frame);
  const Division second(frame);
  ASSERT_GE(first.clusters.size(), 3U);
  ASSERT_EQ(first.clusters.size(), second.clusters.size());
  EXPECT_EQ(first.association.owner, second.association.owner);
  std::set<std::size_t> seen;
  for (std::size_t i = 0; i < first.clusters.size(); ++i) {
    EXPECT_EQ(first.clusters[i].samples, second.clusters[i].samples);
    EXPECT_EQ(first.clusters[i].label, second.clusters[i].label);
    EXPECT_TRUE(std::is_sorted(first.clusters[i].samples.begin(), first.clusters[i].samples.end()));
    for (const std::size_t index : first.clusters[i].samples) {
      EXPECT_TRUE(seen.insert(index).second);
      EXPECT_EQ(first.association.owner[index], Association::kNone);
    }
  }
}

TEST(FindClusters, FindsNothingWithoutReturns) {
  EXPECT_TRUE(Division(RenderScene({}, {})).clusters.empty());
}

}  // namespace
}  // namespace steadymap
