#include "client/bench/simulator/routes/table_top.h"

#include <cmath>
#include <utility>

#include "client/bench/simulator/scene/moving_things.h"
#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

constexpr double kTableHeightM = 0.72;
constexpr double kCircleDurationS = 30.0;

void AddBlock(Scene* scene,
              std::string_view name,
              const Eigen::Vector3d& size_m,
              const Eigen::Vector3d& x_y_yaw,
              const Rgb& color) {
  SceneObject& block = AddStandingBox(scene, name, size_m, x_y_yaw);
  block.T_world_object.translation().z() += kTableHeightM;
  block.semantic_class = SceneClass::kStaticFeature;
  block.color = color;
}

void AddTable(Scene* scene) {
  SceneObject& top = AddStandingBox(scene, "table-top", {1.7, 1.2, 0.04}, {0, 0, 0});
  top.T_world_object.translation().z() = kTableHeightM - 0.02;
  for (const double x_m : {-0.78, 0.78}) {
    for (const double y_m : {-0.53, 0.53}) {
      AddStandingBox(scene, "table-leg", {0.06, 0.06, kTableHeightM - 0.04}, {x_m, y_m, 0});
    }
  }
  for (SceneObject& object : scene->objects()) {
    if (!object.name.starts_with("table-")) continue;
    object.group = "table";
    object.instance = 0;  // As in the recordings: the table is background.
    object.semantic_class = SceneClass::kMachinery;
    object.color = {150, 120, 92};
  }
}

void AddCar(Scene* scene, std::string_view name, const Rgb& color, std::vector<MotionKey> motion) {
  SceneObject car;
  car.name = name;
  car.semantic_class = SceneClass::kDynamicFeature;
  car.color = color;
  car.shape = MakeToyCarShape();
  car.motion = std::move(motion);
  SceneObject& added = scene->Add(std::move(car));
  added.instance = added.id;
}

// Circles the table once, with small changes of height.
Trajectory CircleTable() {
  Trajectory trajectory;
  trajectory.duration_s = kCircleDurationS;
  trajectory.T_world_camera = [](double time_s) {
    const double angle_rad = 2 * M_PI * time_s / kCircleDurationS;
    const Eigen::Vector3d eye(1.45 * std::cos(angle_rad),
                              1.25 * std::sin(angle_rad),
                              kTableHeightM + 0.62 + 0.08 * std::sin(3 * angle_rad));
    return LookAt(eye, {0, 0, kTableHeightM});
  };
  return trajectory;
}

}  // namespace

Route MakeTableTopRoute() {
  Scene scene;
  AddFloor(&scene, {8.0, 8.0});
  AddTable(&scene);
  AddBlock(&scene, "block-red", {0.12, 0.12, 0.12}, {-0.45, 0.30, 0.3}, {190, 60, 50});
  AddBlock(&scene, "block-blue", {0.10, 0.20, 0.10}, {0.50, 0.32, -0.4}, {60, 80, 190});
  AddBlock(&scene, "block-green", {0.14, 0.10, 0.18}, {-0.05, 0.02, 0.8}, {70, 150, 70});
  AddBlock(&scene, "block-yellow", {0.20, 0.09, 0.08}, {-0.55, -0.38, 0.0}, {220, 190, 60});
  const GroundPath oval({{0.55, -0.15}, {0.55, 0.15}, {-0.3, 0.2}, {-0.3, -0.2}}, 0.15, true);
  AddCar(&scene,
         "car-orange",
         {230, 130, 40},
         MoveAlong(
             oval,
             {.speed_m_per_s = 0.12, .duration_s = kCircleDurationS, .height_m = kTableHeightM}));
  const GroundPath straight({{-0.6, -0.48}, {0.6, -0.42}}, 0.1, false);
  AddCar(
      &scene,
      "car-white",
      {225, 225, 230},
      MoveAlong(
          straight,
          {.start_m = 0.35, .speed_m_per_s = 0.06, .duration_s = 12.0, .height_m = kTableHeightM}));
  Route route;
  route.name = "table-top";
  route.camera = DefaultTorwicCalibration().camera;
  route.has_instances = true;
  route.sequences.push_back({"table-top", std::move(scene), CircleTable()});
  return route;
}

}  // namespace steadymap
