#include "core/objects/support.h"

#include <cmath>
#include <cstddef>

#include "core/objects/surface_parts.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

// The floor is hidden below a thing. Beside it, it is looked for so many voxels away.
constexpr int kBesideVoxels = 3;

// The sides of things and the ground that bears them are within 45 degrees of upright and level.
constexpr double kMinCosine = 0.7;

/// True if a point is on a level surface of the background, within `tolerance_m`.
bool IsOnLevelBackground(const Eigen::Vector3d& point_world,
                         double tolerance_m,
                         TsdfSampler* background) {
  const DistanceSample sample = background->Sample(point_world);
  return sample.known && std::abs(sample.distance_m) <= tolerance_m &&
         sample.gradient.z() >= kMinCosine;
}

}  // namespace

bool StandsOnBackground(const TrackedObject& object,
                        const SessionPartParameters& parameters,
                        const WorkingMap& map) {
  const double voxel_m = map.scale().voxel_size_m;
  const double contact_m = parameters.surface.contact_voxels * voxel_m;
  const double lowest_m = object.cuboid().lowest_m();
  TsdfSampler background(map.background(), map.scale());
  std::size_t count = 0;
  for (const OrientedPoint& point : OrientedSurfaceOf(object)) {
    Eigen::Vector3d outward(point.normal_world.x(), point.normal_world.y(), 0.0);
    if (point.position_world.z() > lowest_m + contact_m || outward.norm() < kMinCosine) continue;
    outward.normalize();
    Eigen::Vector3d foot_world = point.position_world;
    foot_world.z() = lowest_m;
    for (int voxels = 1; voxels <= kBesideVoxels; ++voxels) {
      if (!IsOnLevelBackground(foot_world + voxels * voxel_m * outward, contact_m, &background)) {
        continue;
      }
      ++count;
      break;
    }
    if (count >= parameters.min_points) return true;
  }
  return false;
}

}  // namespace steadymap
