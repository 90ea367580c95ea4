#include "core/query/map_mesh.h"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "core/volume/tsdf_mesh.h"
#include "tests/support/analytic_map.h"
#include "tests/support/thread_limit.h"

namespace steadymap {
namespace {

using ::steadymap::testing::AddObject;
using ::steadymap::testing::BoxObject;
using ::steadymap::testing::BoxOverFloor;
using ::steadymap::testing::FloorMap;
using ::steadymap::testing::kBoxPlace;
using ::steadymap::testing::kBoxSizeM;

/// Expects that all triangles refer to existing vertices and that each vertex has a normal.
void ExpectWhole(const Mesh& mesh) {
  EXPECT_EQ(mesh.normals_world.size(), mesh.vertices_world.size());
  EXPECT_TRUE(mesh.colors.empty() || mesh.colors.size() == mesh.vertices_world.size());
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) ASSERT_LT(vertex, mesh.vertices_world.size());
  }
}

TEST(ExtractMapMesh, ObjectsStandInTheWorldBesideTheBackground) {
  const MapSnapshot map = BoxOverFloor();
  const Mesh floor = ExtractMesh(map.background, map.scale, nullptr);
  const Mesh mesh = ExtractMapMesh(ShownVolumes(map), map.scale, nullptr);
  ExpectWhole(mesh);
  ASSERT_GT(mesh.triangles.size(), floor.triangles.size());
  const Eigen::Isometry3d T_object_world = kBoxPlace.ToIsometry().inverse();
  const Box body(-0.5 * kBoxSizeM, 0.5 * kBoxSizeM);
  for (std::size_t i = floor.vertices_world.size(); i < mesh.vertices_world.size(); ++i) {
    const Eigen::Vector3d vertex = T_object_world * mesh.vertices_world[i].cast<double>();
    // Tolerance of half a voxel: the mesh rounds the edges of the box.
    ASSERT_NEAR(testing::DistanceFrom({body}, vertex), 0.0, 0.0251);
    // Normals point outward, away from the box centre.
    EXPECT_GT(mesh.normals_world[i].dot(
                  (mesh.vertices_world[i] - kBoxPlace.position_world.cast<float>())),
              0.0F);
  }
}

TEST(ExtractMapMesh, KeepsToTheBoxInTheWorld) {
  const MapSnapshot map = BoxOverFloor();
  const Box box(Eigen::Vector3d(0.5, -1.0, -1.0), Eigen::Vector3d(2.0, 1.0, 2.0));
  const Mesh mesh = ExtractMapMesh(ShownVolumes(map), map.scale, &box);
  ExpectWhole(mesh);
  std::size_t above_floor = 0;
  for (const Eigen::Vector3f& vertex : mesh.vertices_world) {
    ASSERT_TRUE(box.contains(vertex.cast<double>()));
    above_floor += vertex.z() > 0.3F ? 1 : 0;
  }
  EXPECT_GT(above_floor, 50U);

  const Box elsewhere(Eigen::Vector3d(-2.0, 1.0, 0.5), Eigen::Vector3d(-1.5, 2.0, 2.0));
  EXPECT_TRUE(ExtractMapMesh(ShownVolumes(map), map.scale, &elsewhere).triangles.empty());
}

TEST(ExtractMapMesh, VolumesWithoutColoursAreGreyBesideColouredOnes) {
  MapSnapshot map = FloorMap();
  const MapObject plain = BoxObject(ObjectId(1), kBoxSizeM, kBoxPlace);
  MapObject red = plain;
  red.id = ObjectId(2);
  auto volume = std::make_shared<TsdfGrid>();
  plain.volume->ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    LeafVoxels voxels;
    plain.volume->LoadLeaf(origin, &voxels);
    voxels.color.fill(0x010000FFU);
    voxels.has_color = true;
    volume->StoreLeaf(origin, voxels);
  });
  red.volume = volume;
  AddObject(plain, &map);
  AddObject(red, &map);
  const Mesh mesh = ExtractMapMesh(ShownVolumes(map), map.scale, nullptr);
  ExpectWhole(mesh);
  ASSERT_FALSE(mesh.colors.empty());
  EXPECT_EQ(mesh.colors.front(), kUnknownColor);
  EXPECT_EQ(mesh.colors.back(), (Rgb{255, 0, 0}));
  const std::vector<PlacedVolume> red_first = {VolumeOf(red), VolumeOf(plain)};
  EXPECT_EQ(ExtractMapMesh(red_first, map.scale, nullptr).colors.back(), kUnknownColor);
}

TEST(ExtractMapMesh, NoVolumesHaveNoSurface) {
  EXPECT_TRUE(ExtractMapMesh({}, {}, nullptr).vertices_world.empty());
}

TEST(ExtractMapMesh, EndsSoonAfterItIsCancelled) {
  const MapSnapshot map = BoxOverFloor();
  const std::vector<PlacedVolume> volumes = ShownVolumes(map);
  std::atomic<std::size_t> of_whole = 0;
  const Cancellation never([&of_whole] {
    ++of_whole;
    return false;
  });
  ExtractMapMesh(volumes, map.scale, nullptr, never);
  EXPECT_GT(of_whole, 3 * map.background.leaf_count()) << "three times a leaf, a pass each";
  // Each thread may check for cancellation once more, and each volume is checked once at its start.
  constexpr int kThreads = 3;
  const std::size_t afterwards = kThreads + volumes.size();
  for (std::size_t wanted_for = 0; wanted_for < of_whole; wanted_for += 7) {
    std::atomic<std::size_t> asked = 0;
    const Cancellation later([&] { return asked++ >= wanted_for; });
    testing::RunOnThreads(kThreads,
                          [&] { return ExtractMapMesh(volumes, map.scale, nullptr, later); });
    EXPECT_LE(asked, wanted_for + afterwards);
  }
}

TEST(LeafTouches, TurnedLeavesAreTestedWhereTheyStand) {
  const VoxelScale scale;
  // The leaf spans 0.35 m between voxel centres. Its lowest corner is the origin of the object
  // frame.
  const MapObject object =
      BoxObject(ObjectId(1), kBoxSizeM, {.position_world = {1.0, 1.0, 0.0}, .yaw_rad = M_PI / 4});
  const PlacedVolume volume = VolumeOf(object);
  const auto touches = [&](const Eigen::Vector3d& point) {
    return LeafTouches(volume, {0, 0, 0}, scale, Box(point, point));
  };
  EXPECT_TRUE(touches({1.0, 1.0, 0.0})) << "its corner";
  EXPECT_TRUE(touches({1.0, 1.0 + 0.35 * std::sqrt(2.0) - 1e-6, 0.2})) << "the corner across";
  EXPECT_TRUE(touches({1.24, 1.25, 0.35}));
  EXPECT_FALSE(touches({1.1, 1.05, 0.1})) << "below the slanted side, within its bounds";
  EXPECT_FALSE(touches({1.0, 1.25, 0.36}));
  EXPECT_FALSE(touches({1.0, 1.0 - 1e-6, 0.1}));
}

}  // namespace
}  // namespace steadymap
