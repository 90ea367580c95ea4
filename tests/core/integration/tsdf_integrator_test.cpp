// What a frame adds to a volume and what it clears: edges, thin objects, noise and free rays.

#include "core/integration/tsdf_integrator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/volume/tsdf_mesh.h"
#include "tests/support/analytic_depth.h"
#include "tests/support/analytic_scene.h"

namespace steadymap {
namespace {

using ::steadymap::testing::Body;
using ::steadymap::testing::kGoodsClass;
using ::steadymap::testing::kWallClass;
using ::steadymap::testing::RenderScene;
using ::steadymap::testing::Scene;
using ::steadymap::testing::SceneLook;

MapConfig ConfigWithVoxels(double voxel_size_m) {
  MapConfig config;
  config.voxel_size_m = voxel_size_m;
  config.truncation_m = DefaultTruncationM(voxel_size_m);
  config.max_depth_m = 4.0;
  return config;
}

/// A background and everything that fuses frames into it.
class Fusion {
 public:
  explicit Fusion(const MapConfig& config)
      : scale_{config.voxel_size_m, config.truncation_m}, cloud_(config), integrator_(config) {}

  void Fuse(const Frame& frame, int count = 1) {
    for (int i = 0; i < count; ++i) {
      cloud_.Compute(frame);
      integrator_.SetFrame(cloud_);
      std::vector<LeafOrigin> changed;
      integrator_.Integrate(&background_, &changed);
    }
  }

  Mesh mesh() const { return ExtractMesh(background_, scale_, nullptr); }

 private:
  VoxelScale scale_;
  SemanticCloud cloud_;
  TsdfIntegrator integrator_;
  Background background_;
};

/// Distance from a point to the nearest vertex whose normal is within 60 degrees of `normal`.
double DistanceTo(const Mesh& mesh, const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  double nearest_m = 1e9;
  for (std::size_t i = 0; i < mesh.vertices_world.size(); ++i) {
    if (mesh.normals_world[i].cast<double>().dot(normal) < 0.5) continue;
    nearest_m = std::min(nearest_m, (mesh.vertices_world[i].cast<double>() - point).norm());
  }
  return nearest_m;
}

TEST(TsdfIntegrator, KeepsBothSidesOfAPlateThinnerThanTheTruncation) {
  const Scene plate = {Body(kGoodsClass, {1.96, -0.5, -0.5}, {2.04, 0.5, 0.5})};
  Fusion fusion(ConfigWithVoxels(0.05));
  fusion.Fuse(RenderScene(plate, {{0.6, 0.1, 0.1}, {2.0, 0.0, 0.0}}), 3);
  fusion.Fuse(RenderScene(plate, {{3.4, 0.1, 0.1}, {2.0, 0.0, 0.0}}), 3);
  const Mesh mesh = fusion.mesh();
  for (int column = -4; column <= 4; ++column) {
    for (int row = -4; row <= 4; ++row) {
      const double y = 0.1 * column;
      const double z = 0.1 * row;
      EXPECT_LT(DistanceTo(mesh, {1.96, y, z}, -Eigen::Vector3d::UnitX()), 0.045) << y << " " << z;
      EXPECT_LT(DistanceTo(mesh, {2.04, y, z}, Eigen::Vector3d::UnitX()), 0.045) << y << " " << z;
    }
  }
}

TEST(TsdfIntegrator, MapsASurfaceUpToItsSilhouette) {
  const Scene box = {Body(kGoodsClass, {1.5, -0.2, -0.2}, {1.9, 0.2, 0.2}),
                     Body(kWallClass, {3.5, -4.0, -4.0}, {3.6, 4.0, 4.0})};
  Fusion fusion(ConfigWithVoxels(0.05));
  fusion.Fuse(RenderScene(box, {{0.0, 0.02, 0.01}, {1.5, 0.0, 0.0}}), 3);
  const Mesh mesh = fusion.mesh();
  for (int step = -6; step <= 6; ++step) {
    const double along = 0.03 * step;
    for (const double rim : {-0.19, 0.19}) {
      EXPECT_LT(DistanceTo(mesh, {1.5, along, rim}, -Eigen::Vector3d::UnitX()), 0.045) << along;
      EXPECT_LT(DistanceTo(mesh, {1.5, rim, along}, -Eigen::Vector3d::UnitX()), 0.045) << along;
    }
  }
}

TEST(TsdfIntegrator, ClearsSurfaceThatRaysPassThrough) {
  const Scene room = {Body(kWallClass, {3.0, -4.0, -4.0}, {3.1, 4.0, 4.0})};
  Scene with_box = room;
  with_box.push_back(Body(kGoodsClass, {1.5, -0.3, -0.3}, {1.9, 0.3, 0.3}));
  const SceneLook look = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  const SceneLook aside = {{0.0, 2.0, 0.0}, {1.0, 3.0, 0.0}};
  Fusion fusion(ConfigWithVoxels(0.05));
  fusion.Fuse(RenderScene(with_box, look), 5);
  const Eigen::Vector3d towards_camera = -Eigen::Vector3d::UnitX();
  ASSERT_LT(DistanceTo(fusion.mesh(), {1.5, 0.0, 0.0}, towards_camera), 0.05);
  fusion.Fuse(RenderScene(room, aside), 10);
  EXPECT_LT(DistanceTo(fusion.mesh(), {1.5, 0.0, 0.0}, towards_camera), 0.05)
      << "a frame that does not show the box cleared it";
  fusion.Fuse(RenderScene(room, look), 10);
  EXPECT_GT(DistanceTo(fusion.mesh(), {1.5, 0.0, 0.0}, towards_camera), 0.5);
  EXPECT_LT(DistanceTo(fusion.mesh(), {3.0, 0.0, 0.0}, towards_camera), 0.05);
}

TEST(TsdfIntegrator, DoesNotClearSurfaceWithinTheNoise) {
  const auto wall_at = [](double x_m) {
    return RenderScene({Body(kWallClass, {x_m, -4.0, -4.0}, {x_m + 0.1, 4.0, 4.0})},
                       {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}});
  };
  // At 3 m, the noise of an unknown sensor has a standard deviation of 2.4 cm.
  Fusion fusion(ConfigWithVoxels(0.02));
  fusion.Fuse(wall_at(3.0), 5);
  fusion.Fuse(wall_at(3.07), 20);
  EXPECT_LT(DistanceTo(fusion.mesh(), {3.0, 0.1, 0.1}, -Eigen::Vector3d::UnitX()), 0.02);
  fusion.Fuse(wall_at(3.2), 40);
  EXPECT_GT(DistanceTo(fusion.mesh(), {3.0, 0.1, 0.1}, -Eigen::Vector3d::UnitX()), 0.03);
}

/// Returns a wall at 3 m behind an object at 1 m in the left half of the image.
Frame ObjectBesideWall() {
  Frame frame = RenderScene({}, {});
  for (int v = 0; v < frame.camera.height_px; ++v) {
    for (int u = 0; u < frame.camera.width_px; ++u) {
      frame.depth.units.At(u, v) = u < frame.camera.width_px / 2 ? 10'000 : 30'000;
    }
  }
  return frame;
}

void FillColumns(int first_px, int end_px, std::uint16_t units, Frame* frame) {
  for (int v = 0; v < frame->camera.height_px; ++v) {
    for (int u = first_px; u < end_px; ++u) frame->depth.units.At(u, v) = units;
  }
}

TEST(SemanticCloud, DropsFlyingPixelsOnly) {
  Frame frame = ObjectBesideWall();
  const int edge_px = frame.camera.width_px / 2;
  FillColumns(edge_px, edge_px + 2, 20'000, &frame);
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  const int edge = edge_px / 2;
  for (int column = 0; column < cloud.cells_wide(); ++column) {
    EXPECT_EQ(cloud.At(column, 60).weight > 0.0F, column != edge) << column << " edge " << edge;
  }
}

TEST(SemanticCloud, KeepsARodInFrontOfAWall) {
  Frame frame = ObjectBesideWall();
  FillColumns(0, frame.camera.width_px, 30'000, &frame);
  FillColumns(100, 102, 10'000, &frame);
  SemanticCloud cloud{MapConfig()};
  cloud.Compute(frame);
  EXPECT_GT(cloud.At(50, 60).weight, 0.0F);
  EXPECT_NEAR(cloud.At(50, 60).depth_m, 1.0, 1e-3);
}

}  // namespace
}  // namespace steadymap
