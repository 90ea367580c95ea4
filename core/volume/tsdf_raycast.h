#pragma once

#include <Eigen/Core>

#include "core/types/query_work.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {

/// A ray takes no shorter steps, in voxels: small enough not to step over the front of a thin wall,
/// which is two voxels of positive distance.
inline constexpr double kStepVoxels = 0.5;

/// Where a ray met a surface.
struct RayHit {
  bool hit = false;      ///< Whether it met one; the other fields are zero if not.
  double range_m = 0.0;  ///< From the ray's origin.
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< Unit, towards the side that was observed.
};

/// The first surface that a ray meets from its front, in the volume's frame. `unit_direction` must
/// have length one (asserted). Neither unknown space nor a jump of the distance
/// (`kMaxSurfaceSlope`) stops a ray.
///
/// Each step is taken from `work`, where given; once it allows none, the ray has met nothing.
///
/// Accuracy: the zero of the interpolated distance, to a thousandth of a voxel. Cost: about 0.1 us
/// an empty cube that the ray crosses (`VoxelReader::EmptySideAt`), 0.1 us a voxel within leaves.
RayHit CastRay(TsdfSampler& sampler,
               const Eigen::Vector3d& origin_m,
               const Eigen::Vector3d& unit_direction,
               double max_range_m,
               QueryWork* work = nullptr);

}  // namespace steadymap
