#include "core/volume/tsdf_raycast.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace steadymap {
namespace {

// Step length as a share of the sampled distance. Fused distances can be slightly too long.
constexpr double kSafeShare = 0.8;

constexpr int kBisections = 12;

/// Bisects the interval between `near_m` (positive distance) and `far_m` (not positive) along the
/// ray.
double FindZero(TsdfSampler& sampler,
                const Eigen::Vector3d& origin_m,
                const Eigen::Vector3d& direction,
                double near_m,
                double far_m) {
  for (int i = 0; i < kBisections; ++i) {
    const double middle_m = 0.5 * (near_m + far_m);
    double distance_m = 0.0;
    const bool known = sampler.SampleDistance(origin_m + middle_m * direction, &distance_m);
    (known && distance_m > 0.0 ? near_m : far_m) = middle_m;
  }
  return 0.5 * (near_m + far_m);
}

}  // namespace

RayHit CastRay(TsdfSampler& sampler,
               const Eigen::Vector3d& origin_m,
               const Eigen::Vector3d& unit_direction,
               double max_range_m,
               QueryWork* work) {
  assert(std::abs(unit_direction.norm() - 1.0) < 1e-6);
  const double step_m = kStepVoxels * sampler.scale().voxel_size_m;
  double previous_range_m = 0.0;
  bool in_front = false;
  double range_m = 0.0;
  while (range_m <= max_range_m && (work == nullptr || work->Take())) {
    const Eigen::Vector3d point_m = origin_m + range_m * unit_direction;
    double distance_m = 0.0;
    const bool known = sampler.SampleDistance(point_m, &distance_m);
    if (known && distance_m <= 0.0 && in_front) {
      const double zero_m = FindZero(sampler, origin_m, unit_direction, previous_range_m, range_m);
      const Eigen::Vector3d hit_m = origin_m + zero_m * unit_direction;
      const DistanceSample at_hit = sampler.Sample(hit_m);
      if (at_hit.slope <= kMaxSurfaceSlope) return {true, zero_m, hit_m, at_hit.gradient};
    }
    in_front = known && distance_m > 0.0;
    previous_range_m = range_m;
    const double run_m =
        known ? kSafeShare * std::abs(distance_m) : sampler.EmptyRun(point_m, unit_direction);
    range_m += std::max(step_m, run_m);
  }
  return {};
}

}  // namespace steadymap
