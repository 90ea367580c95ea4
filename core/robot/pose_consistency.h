#pragma once

#include <cstddef>

#include <Eigen/Geometry>

#include "core/association/sample_grid.h"
#include "core/change/min_depth_grid.h"
#include "core/integration/semantic_cloud.h"
#include "core/working/working_map.h"

namespace steadymap {

/// How a frame fits a map at one pose, counted in patches of 16 x 16 pixels.
///
/// Level surface that fits counts for nothing: a floor fits wherever a robot may stand. It counts
/// against the pose where it does not fit.
struct PoseConsistency {
  /// Patches of steep surface where the map has one that faces alike.
  std::size_t fitting = 0;
  /// Patches of surface where the map knows that nothing was, or of a view through what it has.
  std::size_t contradicting = 0;
  /// Patches of steep surface where the map knows nothing.
  std::size_t unknown = 0;
  /// Patches of the picture, whatever they show.
  std::size_t patches = 0;
};

/// One frame as what a guard compares. All of them of one frame.
struct FrameSurface {
  const SemanticCloud& cloud;
  const SampleGrid& samples;
  const MinDepthGrid& tiles;
};

/// When a part of a frame agrees with a map, or contradicts it.
struct PoseConsistencyParameters {
  /// Loose enough for a small error of the pose, tight enough that a wall is no wall at 40 degrees:
  /// largest angle between a measured surface and the mapped one, as a cosine.
  double min_normal_cosine = 0.85;
  /// Points at a flatter angle to the ray are not looked for.
  double min_facing_cosine = 0.25;
  /// A view is through a surface if it ends further away by more than this, metres, and the noise
  /// of the depth: by more than the pose of a robot can be off without a jump.
  double through_m = 0.15;

  friend bool operator==(const PoseConsistencyParameters&,
                         const PoseConsistencyParameters&) = default;
};

/// Compares a frame with the map as if its camera stood at `T_world_camera`, wherever the frame has
/// it. Background and objects that are not archived are asked. A pose that is off by 0.1 m or 2
/// degrees still fits. Cells of dynamic classes have no surface, so they say nothing.
///
/// Cost: about 0.3 ms.
PoseConsistency CompareFrame(const PoseConsistencyParameters& parameters,
                             const FrameSurface& frame,
                             const Eigen::Isometry3d& T_world_camera,
                             const WorkingMap& map);

}  // namespace steadymap
