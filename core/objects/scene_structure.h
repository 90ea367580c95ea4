#pragma once

#include <span>
#include <vector>

#include "core/objects/scene_division.h"
#include "core/objects/surface_overlap.h"
#include "core/objects/surface_parts.h"
#include "core/working/working_map.h"

namespace steadymap {

/// What a surface point of a scene belongs to.
enum class ScenePointKind : char {
  kThing,
  /// Within a voxel of level structure, where the surface of a thing blends with that of the floor
  /// that it stands on. Tells nothing about which things are connected.
  kFoot,
  kStructure,  ///< A large plane, or known background.
};

/// Finds the structure of a scene, such as floors and walls. Returns the kind of each point.
std::vector<ScenePointKind> FindSceneStructure(const SceneDivisionParameters& parameters,
                                               const SurfaceMatchParameters& surface,
                                               std::span<const OrientedPoint> points,
                                               const WorkingMap& map);

/// Finds the planes of a surface with at least `min_area_m2`.
std::vector<PlanePart> FindScenePlanes(const SceneDivisionParameters& parameters,
                                       std::span<const OrientedPoint> points,
                                       double min_area_m2,
                                       double voxel_m);

}  // namespace steadymap
