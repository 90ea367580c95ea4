#include "core/objects/surface_overlap.h"

#include <cmath>

#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

constexpr double kMinMatchingCosine = 0.5;

// Pose error and noise of two looks at one surface, in voxels.
constexpr double kFitVoxels = 1.5;

}  // namespace

SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const VoxelScale& scale) {
  const double tolerance_m = kFitVoxels * scale.voxel_size_m;
  TsdfSampler sampler(other.volume(), scale);
  std::size_t known = 0;
  std::size_t fitting = 0;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3d position = T_other_object * point.position_object.cast<double>();
      double distance_m = 0.0;
      const bool is_inner = sampler.SampleDistance(position, &distance_m);
      if (!is_inner && !sampler.SampleNearest(position, &distance_m)) continue;
      ++known;
      if (std::abs(distance_m) > tolerance_m) continue;
      if (is_inner) {
        const Eigen::Vector3d normal = T_other_object.linear() * point.normal_object.cast<double>();
        if (sampler.Sample(position).gradient.dot(normal) < kMinMatchingCosine) continue;
      }
      ++fitting;
    }
  }
  if (known == 0) return {};
  return {static_cast<double>(known) / static_cast<double>(object.surface().point_count()),
          static_cast<double>(fitting) / static_cast<double>(known)};
}

}  // namespace steadymap
