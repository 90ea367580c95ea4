#pragma once

#include <Eigen/Geometry>

#include "core/working/tracked_object.h"

namespace steadymap {

/// How the surface of one object agrees with another object.
struct SurfaceOverlap {
  double known_share = 0.0;  ///< Share of the points in what the other has observed.
  double fit_share = 0.0;    ///< Of those, the share on its surface, facing the same way.
  double close_share = 0.0;  ///< Of those, the share on it within the error of two looks.
};

/// Returns the standard deviation of the distance between two looks at one surface in place,
/// metres: the error of registered frames, and that of voxels.
double SurfaceSigmaM(const VoxelScale& scale);

/// Compares the surface of `object`, moved by `T_other_object`, with the volume of `other`. A point
/// is on the surface within one and a half voxels, and close to it within three standard deviations
/// of `SurfaceSigmaM`. Zeros for an object without surface.
SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const VoxelScale& scale);

/// Returns the share of what is known of two surfaces where they stand that agrees within the error
/// of two looks, averaged over both, in [0, 1].
double CloseShareInPlace(const TrackedObject& a, const TrackedObject& b, const VoxelScale& scale);

}  // namespace steadymap
