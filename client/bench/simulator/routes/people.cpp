#include "client/bench/simulator/routes/people.h"

#include <cassert>
#include <utility>

#include "client/bench/simulator/routes/torwic_hall.h"
#include "client/bench/simulator/scene/moving_things.h"
#include "client/dataset/layouts/torwic_layout.h"

namespace steadymap {
namespace {

void AddMover(Scene* scene,
              std::string_view name,
              SceneClass semantic_class,
              const MeshShape& shape,
              std::vector<MotionKey> motion) {
  SceneObject mover;
  mover.name = name;
  mover.semantic_class = semantic_class;
  mover.color = semantic_class == SceneClass::kPerson ? Rgb{70, 90, 150} : Rgb{214, 160, 40};
  mover.shape = shape;
  mover.motion = std::move(motion);
  SceneObject& added = scene->Add(std::move(mover));
  added.instance = added.id;
}

GroundPath SquareLane(double half_side_m) {
  return GroundPath({{half_side_m, -half_side_m},
                     {half_side_m, half_side_m},
                     {-half_side_m, half_side_m},
                     {-half_side_m, -half_side_m}},
                    0.6,
                    true);
}

}  // namespace

Route MakePeopleRoute() {
  absl::StatusOr<Scene> hall = MakeTorwicHall("baseline");
  assert(hall.ok());
  Scene scene = *std::move(hall);
  const Trajectory drive = DriveTorwicLoop();
  // One lane on each side of the robot's path, so that no person walks through the camera.
  const GroundPath outer_lane = SquareLane(2.97);
  const GroundPath inner_lane = SquareLane(2.13);
  const double duration_s = drive.duration_s;
  const MeshShape person = MakePersonShape();
  AddMover(
      &scene,
      "person-overtaking",
      SceneClass::kPerson,
      person,
      MoveAlong(outer_lane, {.start_m = 20.5, .speed_m_per_s = 1.1, .duration_s = duration_s}));
  AddMover(&scene,
           "person-oncoming",
           SceneClass::kPerson,
           person,
           MoveAlong(inner_lane, {.start_m = 9, .speed_m_per_s = -0.9, .duration_s = duration_s}));
  AddMover(&scene,
           "person-halting",
           SceneClass::kPerson,
           person,
           MoveAlong(outer_lane, {.start_m = 6, .speed_m_per_s = 0.8, .duration_s = 9}));
  // Ahead of the robot and slightly faster.
  AddMover(
      &scene,
      "forklift",
      SceneClass::kForklift,
      MakeForkliftShape(),
      MoveAlong(TorwicLoop(), {.start_m = 3.5, .speed_m_per_s = 0.6, .duration_s = duration_s}));
  Route route;
  route.name = "people";
  route.camera = DefaultTorwicCalibration().camera;
  route.sequences.push_back({"people", std::move(scene), drive});
  return route;
}

}  // namespace steadymap
