#include "client/bench/simulator/routes/torwic_hall.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "client/bench/simulator/routes/torwic_scenarios.h"
#include "core/types/error.h"

namespace steadymap {
namespace {

constexpr double kLoopSideM = 5.0;
constexpr double kCornerRadiusM = 0.8;
constexpr double kDriveSpeedMPerS = 0.5;

// Two adjacent stacks are 0.94 m long, so each is 0.47 m along its row and 0.5 m deep.
const Eigen::Vector3d kStackSizeM(0.47, 0.5, 2.0);
constexpr double kStackPitchM = 0.47;
constexpr double kOuterRowM = 3.5;
constexpr double kInnerRowM = 1.63;
constexpr double kPilePlaceM = 1.4;

// Inner faces of the fences; the rows of stacks end there.
constexpr double kFenceFaceM = 3.75;
constexpr double kFenceThicknessM = 0.1;
constexpr double kFenceHeightM = 3.0;

// The layout is defined for the top side or the top right corner and rotated from there.
constexpr std::array<const char*, 4> kSides = {"top", "left", "bottom", "right"};
constexpr std::array<const char*, 4> kCorners = {
    "top-right", "top-left", "bottom-left", "bottom-right"};

// Lengths of each corner's two fence legs. The top right one is short: scenario 1-4 pushes stacks
// in that direction.
constexpr std::array<std::array<double, 2>, 4> kFenceLegsM = {
    {{1.0, 1.3}, {1.6, 1.9}, {1.4, 1.7}, {1.9, 1.2}}};

Eigen::Vector3d Turn(const Eigen::Vector3d& x_y_yaw, std::size_t quarter) {
  const double angle_rad = static_cast<double>(quarter) * M_PI / 2;
  const Eigen::Vector2d turned = Eigen::Rotation2Dd(angle_rad) * x_y_yaw.head<2>();
  return {turned.x(), turned.y(), x_y_yaw.z() + angle_rad};
}

// Adds touching objects `group-a`, `group-b`, ... at places given for the first quarter.
void AddGroup(Scene* scene,
              const std::string& group,
              const std::vector<Eigen::Vector3d>& x_y_yaws,
              std::size_t quarter) {
  char letter = 'a';
  for (const Eigen::Vector3d& x_y_yaw : x_y_yaws) {
    SceneObject& stack =
        AddStandingBox(scene, group + "-" + letter++, kStackSizeM, Turn(x_y_yaw, quarter));
    stack.group = group;
  }
}

void AddOuterRow(Scene* scene, std::size_t side) {
  for (int place = -1; place <= 1; ++place) {
    const double x_m = place * kPilePlaceM;
    AddGroup(scene,
             std::string("outer-") + kSides[side] + "-" + std::to_string(place + 2),
             {{x_m - kStackPitchM / 2, kOuterRowM, 0}, {x_m + kStackPitchM / 2, kOuterRowM, 0}},
             side);
  }
}

// Returns three stacks in an L; the corner stack lies in both rows at `row_m`.
std::vector<Eigen::Vector3d> CornerStacks(double row_m) {
  const double beside_m = row_m - (kStackSizeM.y() + kStackPitchM) / 2;
  return {{row_m, row_m, 0}, {row_m - kStackPitchM, row_m, 0}, {row_m, beside_m, M_PI / 2}};
}

void AddWall(Scene* scene,
             const std::string& name,
             const std::string& group,
             const Eigen::Vector3d& size_m,
             const Eigen::Vector3d& x_y_yaw) {
  SceneObject& wall = AddStandingBox(scene, name, size_m, x_y_yaw);
  wall.group = group;
  wall.semantic_class = SceneClass::kWall;
  wall.color = {206, 202, 190};
}

void AddFence(Scene* scene, std::size_t corner) {
  const std::string group = std::string("fence-") + kCorners[corner];
  const auto [first_m, second_m] = kFenceLegsM[corner];
  const double outside_m = kFenceFaceM + kFenceThicknessM;
  const double middle_m = kFenceFaceM + kFenceThicknessM / 2;
  // The first leg includes the corner, the second ends at it.
  const double second_rest_m = second_m - kFenceThicknessM;
  AddWall(scene,
          group + "-a",
          group,
          {first_m, kFenceThicknessM, kFenceHeightM},
          Turn({outside_m - first_m / 2, middle_m, 0}, corner));
  AddWall(scene,
          group + "-b",
          group,
          {second_rest_m, kFenceThicknessM, kFenceHeightM},
          Turn({middle_m, kFenceFaceM - second_rest_m / 2, M_PI / 2}, corner));
}

void AddTagStand(Scene* scene) {
  SceneObject& stand = AddStandingBox(scene, "tag-stand", {0.06, 0.06, 1.2}, {2.4, -3.4, 0});
  stand.group = "tag";
  stand.semantic_class = SceneClass::kStaticFeature;
  stand.color = {60, 60, 64};
  SceneObject& plate = AddStandingBox(scene, "tag-plate", {0.3, 0.02, 0.3}, {2.4, -3.4, 0});
  plate.group = "tag";
  plate.semantic_class = SceneClass::kText;
  plate.color = {240, 240, 240};
  plate.T_world_object.translation().z() = 1.35;
}

// Adds the objects of single scenarios. They are part of every hall during its construction, so
// that an id identifies the same object in all configurations.
void AddScenarioExtras(Scene* scene) {
  constexpr double kAddedM = 2.9;
  for (std::size_t corner = 0; corner < kCorners.size(); ++corner) {
    AddGroup(scene, std::string("2-2-") + kCorners[corner], {{kAddedM, kAddedM, 0}}, corner);
  }
  for (std::size_t corner = 0; corner < kCorners.size(); ++corner) {
    AddGroup(scene, std::string("4-1-") + kCorners[corner], CornerStacks(kOuterRowM), corner);
  }
  // They extend from the left row into the robot's view, through the gaps between its piles.
  AddWall(scene, "4-1-wall-a", "4-1-wall-a", {0.9, 0.1, 2.0}, {-3.45, 0.7, 0});
  AddWall(scene, "4-1-wall-b", "4-1-wall-b", {0.9, 0.1, 2.0}, {-3.45, -0.7, 0});
}

Scene MakeHallWithExtras() {
  Scene scene;
  AddFloor(&scene, {30.0, 30.0});
  for (std::size_t side = 0; side < kSides.size(); ++side) AddOuterRow(&scene, side);
  for (std::size_t side = 0; side < kSides.size(); ++side) {
    AddGroup(&scene,
             std::string("inner-") + kSides[side],
             {{-kStackPitchM / 2, kInnerRowM, 0}, {kStackPitchM / 2, kInnerRowM, 0}},
             side);
  }
  for (std::size_t corner = 0; corner < kCorners.size(); ++corner) {
    AddGroup(&scene, std::string("inner-") + kCorners[corner], CornerStacks(kInnerRowM), corner);
  }
  for (std::size_t corner = 0; corner < kCorners.size(); ++corner) AddFence(&scene, corner);
  AddTagStand(&scene);
  AddScenarioExtras(&scene);
  return scene;
}

}  // namespace

std::vector<std::string> TorwicConfigurations() {
  std::vector<std::string> names = {"baseline"};
  for (const TorwicScenario& scenario : TorwicScenarios()) names.emplace_back(scenario.number);
  return names;
}

absl::StatusOr<Scene> MakeTorwicHall(std::string_view configuration) {
  Scene scene = MakeHallWithExtras();
  scene.RemoveIf([configuration](const SceneObject& object) {
    const bool is_extra = object.name.starts_with("2-2-") || object.name.starts_with("4-1-");
    return is_extra && !object.name.starts_with(configuration);
  });
  if (configuration == "baseline") return scene;
  for (const TorwicScenario& scenario : TorwicScenarios()) {
    if (scenario.number != configuration) continue;
    scenario.apply(&scene);
    return scene;
  }
  return InvalidField(reason::kBadName,
                      "configuration",
                      "unknown configuration of the TorWIC hall: \"" +
                          std::string(configuration.substr(0, 80)) + "\"");
}

GroundPath TorwicLoop() {
  constexpr double kHalfM = kLoopSideM / 2;
  return GroundPath({{kHalfM, -kHalfM}, {kHalfM, kHalfM}, {-kHalfM, kHalfM}, {-kHalfM, -kHalfM}},
                    kCornerRadiusM,
                    true);
}

Trajectory DriveTorwicLoop() {
  return DriveAlong(TorwicLoop(), kDriveSpeedMPerS, kTorwicBaseHeightM);
}

}  // namespace steadymap
