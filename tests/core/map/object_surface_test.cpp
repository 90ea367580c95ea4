// Oracle: planes and spheres, for which distances have a closed form.

#include "core/map/object_surface.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/analytic_solid.h"
#include "tests/support/default_scale.h"

namespace steadymap {
namespace {

using ::steadymap::testing::kScale;
using ::steadymap::testing::MakeVolume;

// Two leaves along each of y and z, and enough leaves along x for the planes below.
Box SmallBounds() { return {Eigen::Vector3d(-0.4, 0.0, 0.0), Eigen::Vector3d(0.39, 0.79, 0.79)}; }

TsdfGrid PlaneVolume(const Eigen::Vector3d& normal, double offset_m) {
  return MakeVolume([&](const Eigen::Vector3d& point) { return normal.dot(point) - offset_m; },
                    SmallBounds(),
                    kScale,
                    [](const Eigen::Vector3d&) { return true; });
}

TsdfGrid SphereVolume(const Eigen::Vector3d& center, double radius_m) {
  return MakeVolume(
      [&](const Eigen::Vector3d& point) { return (point - center).norm() - radius_m; },
      Box(center.array() - radius_m - 0.2, center.array() + radius_m + 0.2),
      kScale,
      [](const Eigen::Vector3d&) { return true; });
}

ObjectSurface SurfaceOf(const TsdfGrid& volume) {
  ObjectSurface surface;
  surface.Rebuild(volume, kScale);
  return surface;
}

std::vector<SurfaceVoxel> PointsOf(const ObjectSurface& surface) {
  std::vector<SurfaceVoxel> points;
  for (const SurfaceLeaf& leaf : surface.leaves()) {
    points.insert(points.end(), leaf.points.begin(), leaf.points.end());
  }
  return points;
}

/// Returns the bytes of the points alone. The capacity of the leaf list depends on the order of
/// insertion.
std::size_t PointBytesOf(const ObjectSurface& surface) {
  return surface.memory_bytes() - surface.leaves().capacity() * sizeof(SurfaceLeaf);
}

void ExpectSame(const ObjectSurface& a, const ObjectSurface& b) {
  ASSERT_EQ(a.leaves().size(), b.leaves().size());
  EXPECT_EQ(PointBytesOf(a), a.point_count() * sizeof(SurfaceVoxel));
  EXPECT_EQ(PointBytesOf(b), PointBytesOf(a));
  for (std::size_t i = 0; i < a.leaves().size(); ++i) {
    const SurfaceLeaf& leaf = a.leaves()[i];
    const SurfaceLeaf& other = b.leaves()[i];
    EXPECT_EQ(leaf.origin, other.origin);
    ASSERT_EQ(leaf.points.size(), other.points.size());
    for (std::size_t j = 0; j < leaf.points.size(); ++j) {
      EXPECT_EQ(leaf.points[j].position_object, other.points[j].position_object);
      EXPECT_EQ(leaf.points[j].normal_object, other.points[j].normal_object);
      EXPECT_EQ(leaf.points[j].cell(), other.points[j].cell());
    }
  }
}

TEST(ObjectSurface, PutsPointsOnAPlaneWithItsNormal) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1.0, 0.3, -0.2).normalized();
  const ObjectSurface surface = SurfaceOf(PlaneVolume(normal, 0.1));
  EXPECT_EQ(surface.point_count(), PointsOf(surface).size());
  ASSERT_GT(surface.point_count(), 200U);
  for (const SurfaceVoxel& point : PointsOf(surface)) {
    EXPECT_NEAR(normal.dot(point.position_object.cast<double>()), 0.1, 1e-4);
    EXPECT_NEAR(normal.dot(point.normal_object.cast<double>()), 1.0, 1e-4);
  }
}

TEST(ObjectSurface, HasOneVoxelAColumnAlongTheAxisThatThePlaneFaces) {
  const Eigen::Vector3d normal = Eigen::Vector3d(1.0, 0.3, -0.2).normalized();
  std::map<std::pair<long, long>, int> voxels_by_column;
  for (const SurfaceVoxel& point : PointsOf(SurfaceOf(PlaneVolume(normal, 0.1)))) {
    // The surface point of a voxel is less than half a voxel from the voxel centre.
    const Eigen::Vector3d voxel = point.position_object.cast<double>() / kScale.voxel_size_m;
    ++voxels_by_column[{std::lround(voxel.y()), std::lround(voxel.z())}];
  }
  EXPECT_EQ(voxels_by_column.size(), 16U * 16U);
  for (const auto& [column, voxels] : voxels_by_column) {
    EXPECT_EQ(voxels, 1) << column.first << " " << column.second;
  }
}

TEST(ObjectSurface, PutsPointsOnASphereWithNormalsOutwards) {
  const Eigen::Vector3d center(0.13, -0.21, 0.34);
  const ObjectSurface surface = SurfaceOf(SphereVolume(center, 0.5));
  ASSERT_GT(surface.point_count(), 500U);
  for (const SurfaceVoxel& point : PointsOf(surface)) {
    const Eigen::Vector3d radius = point.position_object.cast<double>() - center;
    EXPECT_NEAR(radius.norm(), 0.5, 0.001);
    // At the border of a leaf, the gradient is a one-sided difference.
    EXPECT_GT(radius.normalized().dot(point.normal_object.cast<double>()), 0.98);
  }
}

TEST(ObjectSurface, NamesTheEvidenceCellThatHoldsThePoint) {
  const ObjectSurface surface = SurfaceOf(PlaneVolume(Eigen::Vector3d::UnitX(), 0.1));
  for (const SurfaceLeaf& leaf : surface.leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3d voxel = point.position_object.cast<double>() / kScale.voxel_size_m;
      EXPECT_EQ(point.cell(),
                EvidenceCellOf(OffsetInLeaf(static_cast<int>(std::lround(voxel.x())),
                                            static_cast<int>(std::lround(voxel.y())),
                                            static_cast<int>(std::lround(voxel.z())))));
    }
  }
}

TEST(EvidenceCellOf, GivesEightVoxelsToEachCell) {
  std::vector<int> voxels(kEvidenceCells, 0);
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) ++voxels[EvidenceCellOf(offset)];
  EXPECT_EQ(voxels, std::vector<int>(kEvidenceCells, 8));
  EXPECT_EQ(EvidenceCellOf(OffsetInLeaf(2, 4, 6)), EvidenceCellOf(OffsetInLeaf(3, 5, 7)));
  EXPECT_NE(EvidenceCellOf(OffsetInLeaf(1, 4, 6)), EvidenceCellOf(OffsetInLeaf(2, 4, 6)));
}

TEST(ObjectSurface, IsTheSameByUpdatesAsByRebuild) {
  TsdfGrid volume = SphereVolume({0.0, 0.0, 0.0}, 0.5);
  std::vector<LeafOrigin> origins;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView&) { origins.push_back(origin); });
  ObjectSurface updated;
  for (auto origin = origins.rbegin(); origin != origins.rend(); ++origin) {
    updated.Update(volume, kScale, std::vector<LeafOrigin>{*origin});
  }
  ExpectSame(updated, SurfaceOf(volume));

  LeafVoxels voxels;
  volume.LoadLeaf(origins.front(), &voxels);
  for (Voxel& voxel : voxels.voxels) {
    voxel = Voxel(voxel.distance_steps() / 2, voxel.weight_units());
  }
  volume.StoreLeaf(origins.front(), voxels);
  updated.Update(volume, kScale, std::vector<LeafOrigin>{origins.front(), origins.front()});
  ExpectSame(updated, SurfaceOf(volume));
}

TEST(ObjectSurface, LosesTheLeavesThatTheVolumeLost) {
  TsdfGrid volume = SphereVolume({0.0, 0.0, 0.0}, 0.5);
  ObjectSurface surface = SurfaceOf(volume);
  const std::size_t leaves_before = surface.leaves().size();
  const LeafOrigin gone = surface.leaves()[leaves_before / 2].origin;
  volume.StoreLeaf(gone, LeafVoxels());
  const LeafOrigin never_there{800, 0, 0};
  surface.Update(volume, kScale, std::vector<LeafOrigin>{gone, never_there});
  EXPECT_EQ(surface.leaves().size(), leaves_before - 1);
  ExpectSame(surface, SurfaceOf(volume));
}

TEST(ObjectSurface, LeavesOutWhatWasHardlySeen) {
  TsdfGrid volume = PlaneVolume(Eigen::Vector3d::UnitX(), 0.1);
  std::vector<LeafOrigin> origins;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView&) { origins.push_back(origin); });
  for (const LeafOrigin& origin : origins) {
    LeafVoxels voxels;
    volume.LoadLeaf(origin, &voxels);
    for (Voxel& voxel : voxels.voxels) voxel = Voxel(voxel.distance_steps(), 1);
    volume.StoreLeaf(origin, voxels);
  }
  EXPECT_EQ(SurfaceOf(volume).point_count(), 0U);
}

}  // namespace
}  // namespace steadymap
