// Closed-form oracles for fusion, sampling, ray casting and meshing: a plane and a sphere with
// known distances everywhere, observed from several poses.

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/mapper.h"
#include "core/volume/tsdf_mesh.h"
#include "core/volume/tsdf_raycast.h"
#include "core/volume/tsdf_sample.h"
#include "tests/support/analytic_depth.h"
#include "tests/support/analytic_solid.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AnalyticCamera;
using ::steadymap::testing::LookAt;
using ::steadymap::testing::Plane;
using ::steadymap::testing::RangeFunction;
using ::steadymap::testing::RenderAnalytic;
using ::steadymap::testing::Sphere;

/// A surface, its signed distance, and poses that observe it.
struct Oracle {
  const char* name;
  RangeFunction surface;
  std::function<double(const Eigen::Vector3d&)> distance_m;
  std::vector<Eigen::Isometry3d> poses;
};

Oracle TiltedPlane() {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, 1.0).normalized();
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0.1, 0.2, 1.9),
                                     Eigen::Vector3d(1.2, 0.1, 1.3),
                                     Eigen::Vector3d(-1.0, -0.8, 1.5),
                                     Eigen::Vector3d(0.2, 1.4, 1.2)}) {
    poses.push_back(LookAt(eye, {0.0, 0.0, 0.1}));
  }
  return {"plane",
          Plane(normal, 0.07),
          [normal](const Eigen::Vector3d& point) { return normal.dot(point) - 0.07; },
          poses};
}

Oracle Ball() {
  const Eigen::Vector3d center(0.31, -0.22, 0.83);
  constexpr double kRadiusM = 0.6;
  std::vector<Eigen::Isometry3d> poses;
  // The poses are spread evenly, since the error of a fused distance away from the surface depends
  // on the smallest incidence angle of any observation.
  constexpr int kPoses = 40;
  for (int i = 0; i < kPoses; ++i) {
    const double height = 1.0 - (2.0 * i + 1.0) / kPoses;
    const double angle = i * M_PI * (3.0 - std::sqrt(5.0));
    const double radius = std::sqrt(1.0 - height * height);
    const Eigen::Vector3d direction(radius * std::cos(angle), radius * std::sin(angle), height);
    poses.push_back(LookAt(center + 1.7 * direction, center));
  }
  return {"sphere",
          Sphere(center, kRadiusM),
          [center](const Eigen::Vector3d& point) { return (point - center).norm() - kRadiusM; },
          poses};
}

std::shared_ptr<const MapSnapshot> Fuse(const Oracle& oracle, double voxel_size_m) {
  MapConfig config;
  config.voxel_size_m = voxel_size_m;
  config.truncation_m = 3.0 * voxel_size_m;
  const std::unique_ptr<Mapper> mapper = Mapper::Create(config).value();
  for (const Eigen::Isometry3d& pose : oracle.poses) {
    mapper->Integrate(mapper->head().Next(),
                      RenderAnalytic(oracle.surface, AnalyticCamera(), pose));
  }
  return mapper->Commit().snapshot;
}

class TsdfAccuracy : public ::testing::TestWithParam<std::tuple<Oracle (*)(), double>> {
 protected:
  const Oracle oracle_ = std::get<0>(GetParam())();
  const double voxel_size_m_ = std::get<1>(GetParam());
  const std::shared_ptr<const MapSnapshot> snapshot_ = Fuse(oracle_, voxel_size_m_);
};

INSTANTIATE_TEST_SUITE_P(Surfaces,
                         TsdfAccuracy,
                         ::testing::Combine(::testing::Values(TiltedPlane, Ball),
                                            ::testing::Values(0.05, 0.02)),
                         [](const auto& instance) {
                           return std::string(std::get<0>(instance.param)().name) + "At" +
                                  std::to_string(std::lround(1e3 * std::get<1>(instance.param))) +
                                  "Mm";
                         });

TEST_P(TsdfAccuracy, DistanceIsTrueToATenthOfAVoxelWhereItIsMeasured) {
  const double band_m = 0.5 * snapshot_->scale.truncation_m;
  std::size_t checked = 0;
  snapshot_->background.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
      if (!IsSet(leaf.observed, offset)) continue;
      const Eigen::Vector3d center_m =
          Eigen::Vector3d(origin.x + static_cast<int>(offset >> 6),
                          origin.y + static_cast<int>((offset >> 3) & 7),
                          origin.z + static_cast<int>(offset & 7)) *
          voxel_size_m_;
      const double truth_m = oracle_.distance_m(center_m);
      if (std::abs(truth_m) > band_m) continue;
      ++checked;
      const double tolerance_voxels = leaf.voxels[offset].weight_units() > 1 ? 0.1 : 0.75;
      ASSERT_NEAR(static_cast<double>(snapshot_->scale.distance_m(leaf.voxels[offset])),
                  truth_m,
                  tolerance_voxels * voxel_size_m_)
          << "voxel at " << center_m.transpose();
    }
  });
  EXPECT_GT(checked, 500U);
}

TEST_P(TsdfAccuracy, SamplesGiveDistanceAndOutwardGradient) {
  TsdfSampler sampler(snapshot_->background, snapshot_->scale);
  const Eigen::Vector3d probe_m = snapshot_->scale.voxel_size_m * Eigen::Vector3d::Ones();
  std::size_t known = 0;
  for (const Eigen::Isometry3d& pose : oracle_.poses) {
    const RayHit hit = CastRay(sampler, pose.translation(), pose.linear().col(2), 5.0);
    ASSERT_TRUE(hit.hit);
    for (const double share : {-0.4, 0.0, 0.3}) {
      const Eigen::Vector3d point_m = hit.point_m + share * probe_m;
      const DistanceSample sample = sampler.Sample(point_m);
      ASSERT_TRUE(sample.known);
      ++known;
      EXPECT_NEAR(sample.distance_m, oracle_.distance_m(point_m), 0.15 * voxel_size_m_);
      constexpr double kStepM = 1e-5;
      Eigen::Vector3d gradient;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStepM * Eigen::Vector3d::Unit(axis);
        gradient[axis] = oracle_.distance_m(point_m + step) - oracle_.distance_m(point_m - step);
      }
      EXPECT_GT(sample.gradient.dot(gradient.normalized()), 0.99);
      EXPECT_GT(sample.weight, 0.0);
    }
  }
  EXPECT_EQ(known, 3 * oracle_.poses.size());
}

TEST_P(TsdfAccuracy, RaysMeetTheSurfaceWhereItIs) {
  TsdfSampler sampler(snapshot_->background, snapshot_->scale);
  for (const Eigen::Isometry3d& pose : oracle_.poses) {
    for (const Eigen::Vector2d& tilt :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.1, 0.05), Eigen::Vector2d(-0.08, 0.1)}) {
      const Eigen::Vector3d direction =
          (pose.linear() * Eigen::Vector3d(tilt.x(), tilt.y(), 1.0)).normalized();
      const double truth_m = oracle_.surface(pose.translation(), direction);
      const RayHit hit = CastRay(sampler, pose.translation(), direction, 5.0);
      ASSERT_TRUE(hit.hit);
      EXPECT_NEAR(hit.range_m, truth_m, 0.25 * voxel_size_m_);
      EXPECT_NEAR(oracle_.distance_m(hit.point_m), 0.0, 0.15 * voxel_size_m_);
      EXPECT_LT(hit.normal.dot(direction), 0.0);
    }
  }
}

TEST_P(TsdfAccuracy, MeshVerticesLieOnTheSurfaceAndFaceOutwards) {
  const Mesh mesh = ExtractMesh(snapshot_->background, snapshot_->scale, nullptr);
  ASSERT_GT(mesh.triangles.size(), 500U);
  for (const Eigen::Vector3f& vertex : mesh.vertices_world) {
    ASSERT_NEAR(oracle_.distance_m(vertex.cast<double>()), 0.0, 0.2 * voxel_size_m_)
        << vertex.transpose();
  }
  std::size_t outward = 0;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices_world[triangle[0]];
    const Eigen::Vector3f b = mesh.vertices_world[triangle[1]];
    const Eigen::Vector3f c = mesh.vertices_world[triangle[2]];
    const Eigen::Vector3d normal = (b - a).cross(c - a).cast<double>();
    const Eigen::Vector3d middle = ((a + b + c) / 3.0F).cast<double>();
    if (oracle_.distance_m(middle + 1e-3 * normal.normalized()) > oracle_.distance_m(middle)) {
      ++outward;
    }
  }
  // Degenerate triangles have no orientation.
  EXPECT_GT(static_cast<double>(outward), 0.99 * static_cast<double>(mesh.triangles.size()));
}

/// Returns a volume whose distance is `before_m` for x <= 0 and `behind_m` for x >= `gap_m`, and
/// linear between them.
TsdfGrid StepOf(double before_m, double behind_m, double gap_m) {
  return testing::MakeVolume(
      [=](const Eigen::Vector3d& point) {
        const double share = std::clamp(point.x() / gap_m, 0.0, 1.0);
        return before_m + share * (behind_m - before_m);
      },
      Box(Eigen::Vector3d::Constant(-0.5), Eigen::Vector3d::Constant(0.5)),
      VoxelScale(),
      [](const Eigen::Vector3d&) { return true; });
}

bool HasSurface(const TsdfGrid& volume) {
  TsdfSampler sampler(volume, VoxelScale());
  const bool is_hit = CastRay(sampler, {-0.4, 0.02, 0.03}, Eigen::Vector3d::UnitX(), 0.8).hit;
  EXPECT_EQ(is_hit, !ExtractMesh(volume, VoxelScale(), nullptr).triangles.empty());
  return is_hit;
}

// The free space behind a thin object, observed from one side, borders the free space in front of
// it, observed from the other side.
TEST(TsdfSurface, IsNotWhereTheDistanceJumps) {
  EXPECT_FALSE(HasSurface(StepOf(0.12, -0.12, 0.05)));
  EXPECT_FALSE(HasSurface(StepOf(0.02, -0.14, 0.05)));
  EXPECT_FALSE(HasSurface(StepOf(0.14, -0.02, 0.05)));
}

TEST(TsdfSurface, IsWhereTheDistanceFallsALittleTooFast) {
  EXPECT_TRUE(HasSurface(StepOf(0.025, -0.025, 0.05)));
  EXPECT_TRUE(HasSurface(StepOf(0.045, -0.045, 0.05)));
  EXPECT_TRUE(HasSurface(StepOf(0.12, -0.12, 0.15)));
}

TEST(CastRay, LooksThroughUnknownSpaceAndStopsAtItsRange) {
  const Oracle oracle = Ball();
  const std::shared_ptr<const MapSnapshot> snapshot = Fuse(oracle, 0.05);
  TsdfSampler sampler(snapshot->background, snapshot->scale);
  const Eigen::Vector3d origin(0.31, -0.22 - 9.0, 0.83);
  EXPECT_NEAR(CastRay(sampler, origin, Eigen::Vector3d::UnitY(), 20.0).range_m, 8.4, 0.01);
  EXPECT_FALSE(CastRay(sampler, origin, Eigen::Vector3d::UnitY(), 8.0).hit);
  EXPECT_FALSE(CastRay(sampler, origin, -Eigen::Vector3d::UnitY(), 20.0).hit);
}

TEST(TsdfSampler, KnowsNothingWhereNobodyLooked) {
  const std::shared_ptr<const MapSnapshot> snapshot = Fuse(TiltedPlane(), 0.05);
  TsdfSampler sampler(snapshot->background, snapshot->scale);
  EXPECT_FALSE(sampler.Sample({50.0, 0.0, 0.0}).known);
  EXPECT_FALSE(sampler.Sample({std::nan(""), 0.0, 0.0}).known);
  EXPECT_FALSE(sampler.Sample({0.0, std::nan(""), 0.0}).known);
  EXPECT_FALSE(sampler.Sample({0.0, 0.0, std::nan("")}).known);
  EXPECT_FALSE(sampler.Sample({1e30, 0.0, 0.0}).known);
}

TEST(ExtractMesh, KeepsToTheBox) {
  const std::shared_ptr<const MapSnapshot> snapshot = Fuse(TiltedPlane(), 0.05);
  const Box box(Eigen::Vector3d(-0.2, -0.2, -1.0), Eigen::Vector3d(0.2, 0.2, 1.0));
  const Mesh all = ExtractMesh(snapshot->background, snapshot->scale, nullptr);
  const Mesh mesh = ExtractMesh(snapshot->background, snapshot->scale, &box);
  ASSERT_FALSE(mesh.triangles.empty());
  EXPECT_LT(mesh.triangles.size(), all.triangles.size());
  for (const Eigen::Vector3f& vertex : mesh.vertices_world) {
    EXPECT_TRUE(box.contains(vertex.cast<double>()));
  }
}

// Also along the borders to leaves that do not exist.
TEST(ExtractMesh, HasAQuadForEachCrossingBetweenObservedVoxels) {
  LeafVoxels leaf;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    const double distance_m = 0.02 * (static_cast<double>(offset % kLeafSide) - 3.5);
    leaf.voxels[offset] = testing::VoxelWithDistance(distance_m, VoxelScale());
    SetBit(offset, &leaf.observed);
  }
  TsdfGrid volume;
  volume.StoreLeaf({0, 0, 0}, leaf);
  const Mesh mesh = ExtractMesh(volume, VoxelScale(), nullptr);
  EXPECT_EQ(mesh.triangles.size(), 2U * kLeafSide * kLeafSide);
  for (const Eigen::Vector3f& vertex : mesh.vertices_world) {
    EXPECT_NEAR(vertex.z(), 0.175F, 1e-4F);
    EXPECT_GT(vertex.x(), -0.051F);
    EXPECT_LT(vertex.x(), 0.401F);
  }
}

TEST(ExtractMesh, OfAnEmptyMapIsEmpty) {
  const Mesh mesh = ExtractMesh(Background(), VoxelScale(), nullptr);
  EXPECT_TRUE(mesh.vertices_world.empty());
  EXPECT_TRUE(mesh.triangles.empty());
}

}  // namespace
}  // namespace steadymap
