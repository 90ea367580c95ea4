#include "client/bench/simulator/routes/torwic_scenarios.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

namespace steadymap {
namespace {

constexpr double kRotationRad = 12.0 * M_PI / 180;
constexpr double kRingShrinkM = 0.25;
constexpr double kAlternationM = 0.3;
constexpr double kStepM = 0.2;

// Selects the stacks, not the fences or the tag.
bool IsStack(const SceneObject& object) {
  return object.name.starts_with("outer-") || object.name.starts_with("inner-");
}

bool IsFence(const SceneObject& object) { return object.name.starts_with("fence-"); }

bool Has(const SceneObject& object, std::string_view part) {
  return object.name.find(part) != std::string::npos;
}

// Position of an outer pile in its row: 1, 2 or 3.
int PlaceOf(const SceneObject& object) { return object.group.back() - '0'; }

template <typename Predicate>
void Shift(Scene* scene, double x_m, double y_m, Predicate predicate) {
  for (SceneObject& object : scene->objects()) {
    if (predicate(object)) object.T_world_object.translation() += Eigen::Vector3d(x_m, y_m, 0);
  }
}

auto NameStarts(std::string_view prefix) {
  return [prefix](const SceneObject& object) { return object.name.starts_with(prefix); };
}

// Returns the outward direction of an object of a row or a corner: one axis for rows, both for
// corners.
Eigen::Vector3d OutwardOf(const SceneObject& object) {
  const double x = Has(object, "-right") ? 1 : (Has(object, "-left") ? -1 : 0);
  const double y = Has(object, "-top") ? 1 : (Has(object, "-bottom") ? -1 : 0);
  return {x, y, 0};
}

// Moves an object along each of its outward axes.
void MoveOutward(SceneObject* object, double distance_m) {
  object->T_world_object.translation() += distance_m * OutwardOf(*object);
}

void ShrinkInnerRing(Scene* scene) {
  for (SceneObject& object : scene->objects()) {
    if (object.name.starts_with("inner-")) MoveOutward(&object, -kRingShrinkM);
  }
}

void ShrinkBothRings(Scene* scene) {
  ShrinkInnerRing(scene);
  for (SceneObject& object : scene->objects()) {
    if (!object.name.starts_with("outer-")) continue;
    MoveOutward(&object, -kRingShrinkM);
    // The piles beside the middle one move next to it.
    const Eigen::Vector3d out = OutwardOf(object);
    const Eigen::Vector3d along(out.y(), -out.x(), 0);
    object.T_world_object.translation() += (2 - PlaceOf(object)) * kStepM * along;
  }
}

void RotateStacks(Scene* scene) {
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(kRotationRad, Eigen::Vector3d::UnitZ()));
  for (SceneObject& object : scene->objects()) {
    if (IsStack(object)) object.T_world_object = turn * object.T_world_object;
  }
}

void AlternateStacks(Scene* scene) {
  for (SceneObject& object : scene->objects()) {
    if (object.name.starts_with("outer-")) {
      MoveOutward(&object, PlaceOf(object) % 2 == 1 ? kAlternationM : -kAlternationM);
    } else if (object.name.starts_with("inner-")) {
      const bool is_corner = OutwardOf(object).squaredNorm() > 1;
      MoveOutward(&object, is_corner ? -kAlternationM : kAlternationM);
    }
  }
}

void StepStacksOutward(Scene* scene) {
  for (SceneObject& object : scene->objects()) {
    if (object.name.starts_with("outer-")) MoveOutward(&object, PlaceOf(object) * kStepM);
  }
}

void ShiftTopAndSides(Scene* scene) {
  for (SceneObject& object : scene->objects()) {
    if (object.name.starts_with("outer-") && !Has(object, "-bottom")) MoveOutward(&object, 0.5);
  }
}

void MoveFencesOutward(Scene* scene) {
  for (SceneObject& object : scene->objects()) {
    if (IsFence(object)) MoveOutward(&object, 0.5);
  }
}

}  // namespace

const std::vector<TorwicScenario>& TorwicScenarios() {
  static const std::vector<TorwicScenario> scenarios = {
      {"1-1", [](Scene* scene) { Shift(scene, 0, 0.5, NameStarts("outer-top-")); }},
      {"1-2", [](Scene* scene) { Shift(scene, 0, 1.0, NameStarts("outer-top-")); }},
      {"1-3", [](Scene* scene) { Shift(scene, 0.5, 0, NameStarts("outer-top-")); }},
      {"1-4", [](Scene* scene) { Shift(scene, 0.25, 0.25, IsStack); }},
      {"1-5", RotateStacks},
      {"1-6", ShrinkInnerRing},
      {"1-7", ShrinkBothRings},
      {"1-8", AlternateStacks},
      {"1-9", StepStacksOutward},
      {"2-1", [](Scene* scene) { scene->RemoveIf(NameStarts("outer-top-")); }},
      {"2-2",
       [](Scene* scene) {
         scene->RemoveIf([](const SceneObject& object) {
           return object.name.starts_with("inner-") && OutwardOf(object).squaredNorm() > 1;
         });
       }},
      {"2-3", [](Scene* scene) { scene->RemoveIf(IsStack); }},
      {"2-4", [](Scene* scene) { scene->RemoveIf(IsFence); }},
      {"3-1",
       [](Scene* scene) {
         Shift(scene, 0, 0.5, NameStarts("outer-top-"));
         Shift(scene, 0, 0.5, NameStarts("fence-top-"));
       }},
      {"3-2", ShiftTopAndSides},
      {"3-3", MoveFencesOutward},
      {"4-1", [](Scene*) {}},
  };
  return scenarios;
}

}  // namespace steadymap
