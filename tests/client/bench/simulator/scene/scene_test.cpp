#include "client/bench/simulator/scene/scene.h"

#include <gtest/gtest.h>

namespace steadymap {
namespace {

TEST(Scene, KeepsIdsWhenThingsAreRemovedAndNeverGivesThemAgain) {
  Scene scene;
  AddFloor(&scene, {5, 5});
  const std::uint16_t box = AddStandingBox(&scene, "box", {1, 1, 1}, {0, 0, 0}).id;
  scene.RemoveIf([box](const SceneObject& object) { return object.id == box; });
  EXPECT_EQ(scene.Find(box), nullptr);
  const std::uint16_t other = AddStandingBox(&scene, "other", {1, 1, 1}, {0, 0, 0}).id;
  EXPECT_NE(other, box);
  ASSERT_NE(scene.Find(other), nullptr);
  EXPECT_EQ(scene.Find(other)->name, "other");
  EXPECT_EQ(scene.Find(0), nullptr);
}

TEST(Scene, StandingBoxStandsOnTheGroundAndFloorIsNoInstance) {
  Scene scene;
  const SceneObject box = AddStandingBox(&scene, "box", {1, 2, 3}, {4, 5, M_PI / 2});
  const SceneObject floor = AddFloor(&scene, {5, 5});
  double lowest_m = 10;
  double highest_m = 0;
  double widest_x_m = 0;
  for (const Facet& facet : FacetsOf(box.shape, box.T_world_object)) {
    for (const Eigen::Vector3d& vertex : facet.vertices) {
      lowest_m = std::min(lowest_m, vertex.z());
      highest_m = std::max(highest_m, vertex.z());
      widest_x_m = std::max(widest_x_m, std::abs(vertex.x() - 4));
    }
  }
  EXPECT_NEAR(lowest_m, 0, 1e-12);
  EXPECT_NEAR(highest_m, 3, 1e-12);
  EXPECT_NEAR(widest_x_m, 1, 1e-12);  // Its y side, rotated.
  EXPECT_EQ(box.instance, box.id);
  EXPECT_EQ(floor.instance, 0);
}

TEST(CompareScenes, TellsCreatedRemovedAndMoved) {
  Scene before;
  AddStandingBox(&before, "stays", {1, 1, 1}, {0, 0, 0});
  const std::uint16_t goes = AddStandingBox(&before, "goes", {1, 1, 1}, {2, 0, 0}).id;
  const std::uint16_t moves = AddStandingBox(&before, "moves", {1, 1, 1}, {4, 0, 0}).id;
  const std::uint16_t turns = AddStandingBox(&before, "turns", {1, 1, 1}, {6, 0, 0}).id;
  Scene after = before;
  after.RemoveIf([goes](const SceneObject& object) { return object.id == goes; });
  for (SceneObject& object : after.objects()) {
    if (object.id == moves) object.T_world_object.translation().x() += 0.01;
    if (object.id == turns)
      object.T_world_object.rotate(Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitZ()));
  }
  const std::uint16_t comes = AddStandingBox(&after, "comes", {1, 1, 1}, {8, 0, 0}).id;
  const SceneChange change = CompareScenes(before, after);
  EXPECT_EQ(change.removed, std::vector<std::uint16_t>{goes});
  EXPECT_EQ(change.created, std::vector<std::uint16_t>{comes});
  EXPECT_EQ(change.moved, (std::vector<std::uint16_t>{moves, turns}));
  const SceneChange none = CompareScenes(after, after);
  EXPECT_TRUE(none.created.empty() && none.removed.empty() && none.moved.empty());
}

double AreaOf(const Facet& facet) {
  double doubled = 0.0;
  for (int i = 2; i < facet.vertex_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    doubled += (facet.vertices[k - 1] - facet.vertices[0])
                   .cross(facet.vertices[k] - facet.vertices[0])
                   .norm();
  }
  return doubled / 2;
}

// Returns the volume under the facets by the divergence theorem: positive if they face outward.
double VolumeOf(const std::vector<Facet>& facets) {
  double sixfold = 0.0;
  for (const Facet& facet : facets) {
    for (int i = 2; i < facet.vertex_count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      sixfold += facet.vertices[0].dot(facet.vertices[k - 1].cross(facet.vertices[k]));
    }
  }
  return sixfold / 6;
}

double TotalArea(const std::vector<Facet>& facets) {
  double area = 0.0;
  for (const Facet& facet : facets) area += AreaOf(facet);
  return area;
}

TEST(FacetsOf, BoxHasItsSurfaceAndVolume) {
  const Eigen::Isometry3d T_world_box(
      Eigen::Translation3d(3, -2, 1) *
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 1, 0).normalized()));
  const std::vector<Facet> facets = FacetsOf(BoxShape{{1, 2, 3}}, T_world_box);
  EXPECT_EQ(facets.size(), 6U);
  EXPECT_NEAR(TotalArea(facets), 22, 1e-9);
  EXPECT_NEAR(VolumeOf(facets), 6, 1e-9);
}

TEST(FacetsOf, RevolvedMeshesAreClosedAndWindOutward) {
  const auto sphere = std::make_shared<const TriangleMesh>(MakeSphereMesh(1.0, 64));
  const std::vector<Facet> facets = FacetsOf(MeshShape{sphere}, Eigen::Isometry3d::Identity());
  EXPECT_NEAR(TotalArea(facets), 4 * M_PI, 0.03);
  EXPECT_NEAR(VolumeOf(facets), 4 * M_PI / 3, 0.02);
  EXPECT_LT(VolumeOf(facets), 4 * M_PI / 3);
  EXPECT_NEAR(BoundingRadiusM(MeshShape{sphere}), 1.0, 1e-12);
}

TEST(FacetsOf, FlatBoxLosesTheFacetsWithoutArea) {
  EXPECT_EQ(FacetsOf(BoxShape{{1, 1, 0}}, Eigen::Isometry3d::Identity()).size(), 2U);
}

}  // namespace
}  // namespace steadymap
