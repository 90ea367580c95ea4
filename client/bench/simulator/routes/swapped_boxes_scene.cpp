#include "client/bench/simulator/routes/swapped_boxes_scene.h"

#include <cmath>
#include <utility>

#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

constexpr double kSwayDurationS = 12.0;

// Moves from side to side with both boxes in view.
Trajectory SwayBefore() {
  Trajectory trajectory;
  trajectory.duration_s = kSwayDurationS;
  trajectory.T_world_camera = [](double time_s) {
    const double sideways_m = 1.2 * std::sin(2 * M_PI * time_s / kSwayDurationS);
    return LookAt({sideways_m, -2.6, 1.1}, {0.3 * sideways_m, 0, 0.5});
  };
  return trajectory;
}

}  // namespace

Route MakeSwappedBoxesRoute() {
  Scene both;
  AddFloor(&both, {12.0, 12.0});
  SceneObject& wall = AddStandingBox(&both, "wall", {6.0, 0.1, 2.5}, {0, 1.2, 0});
  wall.semantic_class = SceneClass::kWall;
  wall.color = {206, 202, 190};
  const Eigen::Vector3d size_m(0.6, 0.5, 0.8);
  const std::uint16_t left = AddStandingBox(&both, "twin-left", size_m, {-0.8, 0, 0}).id;
  const std::uint16_t right = AddStandingBox(&both, "twin-right", size_m, {0.8, 0, 0}).id;

  Scene swapped = both;
  for (SceneObject& object : swapped.objects()) {
    if (object.id == left) object.T_world_object = both.Find(right)->T_world_object;
    if (object.id == right) object.T_world_object = both.Find(left)->T_world_object;
  }
  Scene one_left = swapped;
  one_left.RemoveIf([right](const SceneObject& object) { return object.id == right; });

  Route route;
  route.name = "twin";
  route.camera = DefaultTorwicCalibration().camera;
  route.sequences.push_back({"both", std::move(both), SwayBefore()});
  route.sequences.push_back({"swapped", std::move(swapped), SwayBefore()});
  route.sequences.push_back({"one-left", std::move(one_left), SwayBefore()});
  return route;
}

}  // namespace steadymap
