#include "client/bench/evaluation/truth/surface_points.h"

#include <cmath>

#include <gtest/gtest.h>

#include "client/bench/evaluation/truth/point_index.h"
#include "tests/support/analytic_solid.h"

namespace steadymap {
namespace {

constexpr double kSpacingM = 0.05;

// Returns the largest distance of a point of the rectangle [0, 1] x [0, 0.6] at z = 0 from its
// nearest sample, probed on a fine grid.
double LargestGapM(const std::vector<SurfacePoint>& samples) {
  double largest_m = 0.0;
  for (int i = 0; i <= 50; ++i) {
    for (int j = 0; j <= 30; ++j) {
      const Eigen::Vector3f probe(static_cast<float>(i) * 0.02F, static_cast<float>(j) * 0.02F, 0);
      double nearest_m = 1e9;
      for (const SurfacePoint& sample : samples) {
        nearest_m =
            std::min(nearest_m, static_cast<double>((sample.position_world - probe).norm()));
      }
      largest_m = std::max(largest_m, nearest_m);
    }
  }
  return largest_m;
}

TEST(SampleFacets, CoversARectangleEvenlyWithItsNormal) {
  const std::vector<SurfacePoint> samples = SampleFacets(
      FacetsOf(RectangleShape{{1.0, 0.6}}, Eigen::Isometry3d(Eigen::Translation3d(0.5, 0.3, 0.0))),
      kSpacingM);
  EXPECT_EQ(samples.size(), 20U * 12U);
  EXPECT_LE(LargestGapM(samples), kSpacingM * std::sqrt(0.5) + 1e-6);
  for (const SurfacePoint& sample : samples) {
    EXPECT_NEAR(std::abs(sample.normal_world.z()), 1.0, 1e-6);
  }
}

TEST(SampleFacets, NormalsOfABoxPointOutwards) {
  const std::vector<SurfacePoint> samples =
      SampleFacets(FacetsOf(BoxShape{{1, 1, 1}}, Eigen::Isometry3d::Identity()), 0.1);
  EXPECT_EQ(samples.size(), 600U);
  for (const SurfacePoint& sample : samples) {
    EXPECT_GT(sample.normal_world.dot(sample.position_world), 0.49F);
  }
}

TEST(SampleMesh, CoversTrianglesEvenlyAndSkipsThoseWithoutArea) {
  Mesh mesh;
  mesh.vertices_world = {{0, 0, 0}, {1, 0, 0}, {1, 0.6F, 0}, {0, 0.6F, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 1, 1}};
  const std::vector<SurfacePoint> samples = SampleMesh(mesh, kSpacingM);
  EXPECT_LE(LargestGapM(samples), kSpacingM);
  EXPECT_LT(samples.size(), 1000U);
  for (const SurfacePoint& sample : samples) EXPECT_NEAR(sample.normal_world.z(), 1.0, 1e-6);
}

TEST(SampleMesh, NothingGivesNothing) { EXPECT_TRUE(SampleMesh(Mesh(), kSpacingM).empty()); }

TEST(PointIndex, FindsPointsUpToItsReachAcrossCells) {
  PointIndex index(0.1);
  index.Add(Eigen::Vector3f(0.049F, 0, 0));
  EXPECT_TRUE(index.HasNear({0.148F, 0, 0}));
  EXPECT_FALSE(index.HasNear({0.15F, 0, 0}));
  EXPECT_TRUE(index.HasNear({-0.05F, 0, 0}));
  EXPECT_FALSE(index.HasNear({0.049F, 0.08F, 0.08F}));
}

TEST(SampleMap, AnEmptyMapHasNoSurface) {
  EXPECT_TRUE(SampleMap(MapSnapshot(), kSpacingM).empty());
}

// A volume with a plane at z = `height_m` in its own frame, observed from above.
std::shared_ptr<const TsdfGrid> PlaneVolume(const VoxelScale& scale, double height_m) {
  auto grid = std::make_shared<TsdfGrid>();
  LeafVoxels voxels;
  for (std::int32_t x = 0; x < kLeafSide; ++x) {
    for (std::int32_t y = 0; y < kLeafSide; ++y) {
      for (std::int32_t z = 0; z < kLeafSide; ++z) {
        const std::size_t offset = OffsetInLeaf(x, y, z);
        voxels.voxels.at(offset) =
            testing::VoxelWithDistance(z * scale.voxel_size_m - height_m, scale);
        voxels.observed.at(offset >> 6) |= std::uint64_t{1} << (offset & 63U);
      }
    }
  }
  grid->StoreLeaf({0, 0, 0}, voxels);
  return grid;
}

TEST(SampleObject, SurfaceStandsWhereTheObjectStands) {
  const VoxelScale scale;
  MapObject object;
  object.volume = PlaneVolume(scale, 0.16);
  object.T_world_object.position_world = {2.0, 0.0, 1.0};
  object.T_world_object.yaw_rad = M_PI / 2;
  const std::vector<SurfacePoint> samples = SampleObject(object, scale, 0.025);
  ASSERT_FALSE(samples.empty());
  for (const SurfacePoint& sample : samples) {
    EXPECT_NEAR(sample.position_world.z(), 1.16, 0.002);
    EXPECT_LE(sample.position_world.x(), 2.0F);
    EXPECT_GE(sample.position_world.y(), 0.0F);
    EXPECT_GT(sample.normal_world.z(), 0.99F);
  }
}

}  // namespace
}  // namespace steadymap
