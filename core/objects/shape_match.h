#pragma once

#include <limits>

#include <Eigen/Geometry>

#include "core/objects/surface_overlap.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// The pose at which the shape of one object agrees best with the surface of another object.
/// `overlap` is of the surface of the other object, `reverse_overlap` of that of the placed shape.
struct ShapeMatch : MutualOverlap {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();

  /// Returns the share of the surface of the other object that is known to agree, in [0, 1].
  double confidence() const { return overlap.known_fit_share(); }
};

/// Returns the pose of an upright object; drops rotations about other axes than z.
UprightPose UprightPoseOf(const Eigen::Isometry3d& T_world_object);

/// Places the shape of `before` at the surface of `after`: by their cuboids, turned by each quarter
/// turn and with any sides in common, since a frame shows a part of the sides only. Registers those
/// from which the surfaces are closest, and returns the best; an empty match if there is none.
/// `free_space`: seen together with `after`; the placed shape has no surface there. `max_step_m`:
/// by how much the lowest points of both may differ in height.
ShapeMatch MatchShapes(const TrackedObject& before,
                       const TrackedObject& after,
                       const FreeSpaceSince& free_space,
                       const SurfaceMatchParameters& parameters,
                       const VoxelScale& scale,
                       double max_step_m = std::numeric_limits<double>::infinity());

}  // namespace steadymap
