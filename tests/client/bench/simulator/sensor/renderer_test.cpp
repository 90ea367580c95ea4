#include "client/bench/simulator/sensor/renderer.h"

#include <cmath>
#include <memory>
#include <random>

#include <gtest/gtest.h>

#include "client/bench/simulator/scene/trajectory.h"

namespace steadymap {
namespace {

constexpr PinholeCamera kSmallCamera = {160, 90, 115.0, 116.0, 81.3, 44.4};

// Inverse depth is linear along a row and rounded to float a few times.
constexpr double kRelativeTolerance = 3e-6;

double DepthAt(const SurfaceImage& image, int u, int v) {
  const auto inverse = static_cast<double>(image.pixels.inverse_depth_per_m.At(u, v));
  return inverse > 0 ? 1 / inverse : 0.0;
}

const SceneObject* ObjectAt(const SurfaceImage& image, int u, int v) {
  return image.surfaces[image.pixels.surface.At(u, v)].object;
}

// Returns the depth along the camera's z axis at which a pixel's ray enters a box; 0 without a hit.
double RayBoxDepth(const Eigen::Vector3d& size_m,
                   const Eigen::Isometry3d& T_box_camera,
                   const Eigen::Vector3d& ray_camera) {
  const Eigen::Vector3d origin = T_box_camera.translation();
  const Eigen::Vector3d direction = T_box_camera.linear() * ray_camera;
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double first = (-size_m[axis] / 2 - origin[axis]) / direction[axis];
    const double second = (size_m[axis] / 2 - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(first, second));
    leave = std::min(leave, std::max(first, second));
  }
  return enter < leave ? enter : 0.0;
}

// Returns the depth at which a pixel's ray hits a triangle, by Cramer's rule; 0 without a hit.
double RayTriangleDepth(const std::array<Eigen::Vector3d, 3>& corners_camera,
                        const Eigen::Vector3d& ray_camera) {
  Eigen::Matrix3d system;
  system << corners_camera[1] - corners_camera[0], corners_camera[2] - corners_camera[0],
      -ray_camera;
  // Seen from behind.
  if (system.determinant() <= 1e-15) return 0.0;
  const Eigen::Vector3d solution = system.inverse() * -corners_camera[0];
  const bool is_inside = solution.x() >= 0 && solution.y() >= 0 && solution.x() + solution.y() <= 1;
  return is_inside && solution.z() > 0 ? solution.z() : 0.0;
}

SceneObject Thing(Shape shape, const Eigen::Isometry3d& T_world_object, SceneClass semantic_class) {
  SceneObject object;
  object.shape = std::move(shape);
  object.T_world_object = T_world_object;
  object.semantic_class = semantic_class;
  return object;
}

TEST(Renderer, PlaneFacingTheCameraHasOneDepth) {
  Scene scene;
  const Eigen::Isometry3d T_world_plane(Eigen::Translation3d(0, 0, 2.5));
  scene.Add(Thing(RectangleShape{{10, 10}}, T_world_plane, SceneClass::kWall));
  Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
  const SurfaceImage& image = renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
  for (int v = 0; v < kSmallCamera.height_px; ++v) {
    for (int u = 0; u < kSmallCamera.width_px; ++u) {
      EXPECT_FLOAT_EQ(image.pixels.inverse_depth_per_m.At(u, v), 0.4F);
    }
  }
}

TEST(Renderer, FloorThatRunsBehindTheCameraHasTheDepthOfItsPlane) {
  Scene scene;
  AddFloor(&scene, {200, 200});
  SensorModel sensor = SensorModel::Ideal();
  sensor.visible_range_m = 15;
  Renderer renderer(&scene, kSmallCamera, sensor);
  const Eigen::Isometry3d T_world_camera = LookAt({0.3, -0.2, 1.1}, {2.0, 0.7, 0.6});
  const SurfaceImage& image = renderer.RenderSurfaces(T_world_camera, 0);
  int hit_count = 0;
  for (int v = 0; v < kSmallCamera.height_px; ++v) {
    for (int u = 0; u < kSmallCamera.width_px; ++u) {
      const Eigen::Vector3d ray_world = T_world_camera.linear() * kSmallCamera.Ray(u, v);
      const double depth_m = -1.1 / ray_world.z();
      const bool is_visible = ray_world.z() < 0 && depth_m < 15;
      ASSERT_EQ(DepthAt(image, u, v) > 0, is_visible) << u << " " << v;
      if (!is_visible) continue;
      ASSERT_NEAR(DepthAt(image, u, v), depth_m, 2e-5 * depth_m);
      ++hit_count;
    }
  }
  EXPECT_GT(hit_count, kSmallCamera.width_px * kSmallCamera.height_px / 3);
}

TEST(Renderer, BoxMeetsEveryRayWhereTheSlabTestDoes) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d size_m(0.5 + 0.4 * unit(random), 1.0 + unit(random) / 2, 0.7);
    Eigen::Isometry3d T_world_box = Eigen::Isometry3d::Identity();
    T_world_box.translation() = Eigen::Vector3d(unit(random), unit(random), 2.5 + unit(random));
    T_world_box.rotate(Eigen::AngleAxisd(3 * unit(random), Eigen::Vector3d(1, 2, 3).normalized()));
    Scene scene;
    scene.Add(Thing(BoxShape{size_m}, T_world_box, SceneClass::kGoods));
    Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
    const SurfaceImage& image = renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
    for (int v = 0; v < kSmallCamera.height_px; ++v) {
      for (int u = 0; u < kSmallCamera.width_px; ++u) {
        const double depth_m = RayBoxDepth(size_m, T_world_box.inverse(), kSmallCamera.Ray(u, v));
        ASSERT_NEAR(DepthAt(image, u, v), depth_m, kRelativeTolerance * (depth_m + 1))
            << trial << ": " << u << " " << v;
      }
    }
  }
}

TEST(Renderer, SphereMeshMeetsEveryRayWhereItsTrianglesDo) {
  const auto mesh = std::make_shared<const TriangleMesh>(MakeSphereMesh(0.8, 24));
  const Eigen::Isometry3d T_world_sphere(Eigen::Translation3d(0.2, -0.1, 2.0));
  Scene scene;
  scene.Add(Thing(MeshShape{mesh}, T_world_sphere, SceneClass::kGoods));
  Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
  const SurfaceImage& image = renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
  int hit_count = 0;
  for (int v = 0; v < kSmallCamera.height_px; v += 3) {
    for (int u = 0; u < kSmallCamera.width_px; u += 3) {
      double nearest_m = 0.0;
      for (const auto& [a, b, c] : mesh->triangles) {
        const double depth_m = RayTriangleDepth({T_world_sphere * mesh->vertices_object[a],
                                                 T_world_sphere * mesh->vertices_object[b],
                                                 T_world_sphere * mesh->vertices_object[c]},
                                                kSmallCamera.Ray(u, v));
        if (depth_m > 0 && (nearest_m == 0 || depth_m < nearest_m)) nearest_m = depth_m;
      }
      ASSERT_NEAR(DepthAt(image, u, v), nearest_m, 2e-5) << u << " " << v;
      hit_count += nearest_m > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(hit_count, 500);
}

TEST(Renderer, SphereMeshLiesWithinItsChordsOfTheSphere) {
  constexpr double kRadiusM = 0.8;
  constexpr int kSegments = 48;
  const Eigen::Vector3d center(0.0, 0.0, 2.0);
  Scene scene;
  scene.Add(
      Thing(MeshShape{std::make_shared<const TriangleMesh>(MakeSphereMesh(kRadiusM, kSegments))},
            Eigen::Isometry3d(Eigen::Translation3d(center)),
            SceneClass::kGoods));
  Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
  const SurfaceImage& image = renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
  // The centre of a facet lies inside the sphere by at most the two sagittas of its sides.
  const double sagitta_m = 2 * kRadiusM * (1 - std::cos(M_PI / kSegments));
  for (int v = 0; v < kSmallCamera.height_px; ++v) {
    for (int u = 0; u < kSmallCamera.width_px; ++u) {
      const double depth_m = DepthAt(image, u, v);
      if (depth_m == 0) continue;
      const double distance_m = (depth_m * kSmallCamera.Ray(u, v) - center).norm();
      ASSERT_LE(distance_m, kRadiusM + 1e-5);
      ASSERT_GE(distance_m, kRadiusM - sagitta_m);
    }
  }
}

TEST(Renderer, MeshOfABoxLooksLikeTheBoxWithoutGaps) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Vector3d size_m(1.0, 0.8, 0.6);
    TriangleMesh mesh;
    AppendBox(size_m, Eigen::Vector3d::Zero(), &mesh);
    Eigen::Isometry3d T_world_box = Eigen::Isometry3d::Identity();
    T_world_box.translation() = Eigen::Vector3d(unit(random) / 2, unit(random) / 2, 1.8);
    T_world_box.rotate(Eigen::AngleAxisd(3 * unit(random), Eigen::Vector3d(3, 1, 2).normalized()));
    Scene boxes;
    boxes.Add(Thing(BoxShape{size_m}, T_world_box, SceneClass::kGoods));
    Scene meshes;
    meshes.Add(Thing(
        MeshShape{std::make_shared<const TriangleMesh>(mesh)}, T_world_box, SceneClass::kGoods));
    Renderer box_renderer(&boxes, kSmallCamera, SensorModel::Ideal());
    Renderer mesh_renderer(&meshes, kSmallCamera, SensorModel::Ideal());
    const SurfaceImage& box = box_renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
    const SurfaceImage& triangles = mesh_renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
    for (int v = 0; v < kSmallCamera.height_px; ++v) {
      for (int u = 0; u < kSmallCamera.width_px; ++u) {
        ASSERT_NEAR(DepthAt(box, u, v), DepthAt(triangles, u, v), 1e-5) << u << " " << v;
      }
    }
  }
}

TEST(Renderer, NearerThingHidesTheFartherInWhateverOrderTheyStand) {
  for (const bool near_first : {true, false}) {
    Scene scene;
    for (const double depth_m : {near_first ? 1.0 : 3.0, near_first ? 3.0 : 1.0}) {
      scene.Add(Thing(RectangleShape{{10, 10}},
                      Eigen::Isometry3d(Eigen::Translation3d(0, 0, depth_m)),
                      depth_m < 2 ? SceneClass::kGoods : SceneClass::kWall));
    }
    Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
    const SurfaceImage& image = renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), 0);
    EXPECT_EQ(ObjectAt(image, 80, 45)->semantic_class, SceneClass::kGoods);
    EXPECT_NEAR(DepthAt(image, 80, 45), 1.0, 1e-6);
  }
}

TEST(Renderer, ThingsBehindTheCameraOrOutOfSightAreNotDrawn) {
  Scene scene;
  for (const double z_m : {-2.0, 30.0}) {
    scene.Add(Thing(BoxShape{{1, 1, 1}},
                    Eigen::Isometry3d(Eigen::Translation3d(0, 0, z_m)),
                    SceneClass::kGoods));
  }
  Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
  const Frame frame = renderer.Render({}, {});
  EXPECT_EQ(frame.depth.units, Image<std::uint16_t>(kSmallCamera.width_px, kSmallCamera.height_px));
  EXPECT_EQ(frame.labels, Image<std::uint16_t>(kSmallCamera.width_px, kSmallCamera.height_px));
}

TEST(Renderer, EmptySceneGivesAnEmptyFrame) {
  const Scene scene;
  Renderer renderer(&scene, kSmallCamera, SensorModel::Full());
  const Frame frame = renderer.Render({}, {.include_instances = true, .include_color = true});
  EXPECT_EQ(frame.depth.units, Image<std::uint16_t>(kSmallCamera.width_px, kSmallCamera.height_px));
  EXPECT_EQ(frame.color.At(5, 5), Rgb{});
}

TEST(Renderer, FrameHoldsMillimetresLabelsInstancesAndShadedColour) {
  Scene scene;
  SceneObject wall = Thing(RectangleShape{{0.4, 0.4}},
                           Eigen::Isometry3d(Eigen::Translation3d(0, 0, 1.2345)),
                           SceneClass::kRack);
  wall.color = {200, 100, 50};
  wall.instance = 77;
  scene.Add(wall);
  Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
  const Frame frame = renderer.Render({}, {.include_instances = true, .include_color = true});
  EXPECT_EQ(frame.camera, kSmallCamera);
  EXPECT_EQ(frame.depth.metres_per_unit, 0.001);
  EXPECT_NEAR(frame.depth.units.At(81, 44), 1234.5, 0.51);
  EXPECT_EQ(frame.labels.At(81, 44), 6);
  EXPECT_EQ(frame.instances.At(81, 44), 77);
  const Rgb color = frame.color.At(81, 44);
  EXPECT_LE(color[0], 200);
  EXPECT_GE(color[0], 80);
  EXPECT_NEAR(color[0], 2.0 * color[1], 2.0);
  EXPECT_EQ(frame.depth.units.At(0, 0), kNoDepth);
  EXPECT_EQ(frame.labels.At(0, 0), 0);
  EXPECT_EQ(frame.instances.At(0, 0), 0);
}

TEST(Renderer, DepthOutsideTheSensorsRangeIsMissingButLabelled) {
  for (const double depth_m : {0.25, 5.1}) {
    Scene scene;
    scene.Add(Thing(RectangleShape{{50, 50}},
                    Eigen::Isometry3d(Eigen::Translation3d(0, 0, depth_m)),
                    SceneClass::kWall));
    Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());
    const Frame frame = renderer.Render({}, {});
    EXPECT_EQ(frame.depth.units.At(80, 45), kNoDepth);
    EXPECT_EQ(frame.labels.At(80, 45), 4);
  }
}

TEST(Renderer, MovingThingIsWhereItsMotionPutsIt) {
  Scene scene;
  SceneObject box = Thing(BoxShape{{2, 2, 1}}, Eigen::Isometry3d::Identity(), SceneClass::kPerson);
  box.motion = {{1.0, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 2))},
                {3.0, Eigen::Isometry3d(Eigen::Translation3d(0, 0, 4))}};
  scene.Add(box);
  Renderer renderer(&scene, kSmallCamera, SensorModel::Ideal());

  struct Case {
    double time_s;
    double depth_m;
  };

  for (const Case& c : {Case{0, 1.5}, Case{1, 1.5}, Case{2, 2.5}, Case{3, 3.5}, Case{9, 3.5}}) {
    const SurfaceImage& image = renderer.RenderSurfaces(Eigen::Isometry3d::Identity(), c.time_s);
    EXPECT_NEAR(DepthAt(image, 80, 45), c.depth_m, 1e-5) << c.time_s;
  }
}

}  // namespace
}  // namespace steadymap
