#include "core/objects/surface_overlap.h"

#include <cmath>

#include "core/map/pose_error.h"
#include "core/volume/tsdf_sample.h"

namespace steadymap {
namespace {

/// True if the surface within `tolerance_m` of a point faces `normal`. Around an edge, the side
/// that the point is of may be the one beside it.
bool HasFace(const Eigen::Vector3d& point,
             const Eigen::Vector3d& normal,
             double tolerance_m,
             double min_cosine,
             TsdfSampler* sampler) {
  if (sampler->Sample(point).gradient.dot(normal) >= min_cosine) return true;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Eigen::Vector3d beside = point;
      beside[axis] += sign * sampler->scale().voxel_size_m;
      const DistanceSample sample = sampler->Sample(beside);
      if (sample.known && std::abs(sample.distance_m) <= tolerance_m &&
          sample.gradient.dot(normal) >= min_cosine) {
        return true;
      }
    }
  }
  return false;
}

/// True if a point of a surface, what is before it and what is behind it are free: the surface
/// would have been seen.
bool IsInFreeSpace(const Eigen::Vector3d& point_world,
                   const Eigen::Vector3d& normal_world,
                   const FreeSpaceSince& free_space) {
  const Eigen::Vector3d step = free_space.cell_size_m() * normal_world;
  return free_space.IsFree(point_world) && free_space.IsFree(point_world + step) &&
         free_space.IsFree(point_world - step);
}

/// What is known of surface that lies behind another surface and faces another way.
enum class HiddenSurface {
  kDisagrees,
  kIsUnknown,  ///< It was hidden from the looks at the other surface.
};

/// What is known beside the surface of an object.
struct Surroundings {
  const FreeSpaceSince* free_space = nullptr;  ///< Around it; null: unknown.
  HiddenSurface hidden = HiddenSurface::kDisagrees;
};

/// Compares the surface of an object with a volume. What the volume has not observed is known if
/// `is_in_free_space(point, normal)` is true, in the frame of the volume.
template <typename IsInFreeSpaceFunction>
SurfaceOverlap Compare(const TrackedObject& object,
                       const Eigen::Isometry3d& T_volume_object,
                       const SurfaceMatchParameters& parameters,
                       const IsInFreeSpaceFunction& is_in_free_space,
                       HiddenSurface hidden,
                       TsdfSampler* sampler) {
  const VoxelScale& scale = sampler->scale();
  const double tolerance_m = parameters.contact_voxels * scale.voxel_size_m;
  const double close_m = parameters.max_sigmas * SurfaceSigmaM(parameters, scale);
  const double min_cosine = parameters.min_normal_cosine;
  std::size_t known = 0;
  std::size_t fitting = 0;
  std::size_t close = 0;
  SurfaceOverlap overlap;
  for (const SurfaceLeaf& leaf : object.surface().leaves()) {
    for (const SurfaceVoxel& point : leaf.points) {
      const Eigen::Vector3d position = T_volume_object * point.position_object.cast<double>();
      const Eigen::Vector3d normal = T_volume_object.linear() * point.normal_object.cast<double>();
      double distance_m = 0.0;
      const bool is_inner = sampler->SampleDistance(position, &distance_m);
      if (!is_inner && !sampler->SampleNearestPlane(position, normal, &distance_m)) {
        if (is_in_free_space(position, normal)) ++known;
        continue;
      }
      if (hidden == HiddenSurface::kIsUnknown && is_inner && distance_m <= close_m &&
          !HasFace(position, normal, tolerance_m, min_cosine, sampler)) {
        continue;
      }
      ++known;
      if (std::abs(distance_m) > tolerance_m) continue;
      if (is_inner && !HasFace(position, normal, tolerance_m, min_cosine, sampler)) continue;
      ++fitting;
      if (std::abs(distance_m) > close_m) continue;
      if (is_inner && !HasFace(position, normal, close_m, min_cosine, sampler)) continue;
      ++close;
    }
  }
  if (known == 0) return overlap;
  overlap.known_share =
      static_cast<double>(known) / static_cast<double>(object.surface().point_count());
  overlap.fit_share = static_cast<double>(fitting) / static_cast<double>(known);
  overlap.close_share = static_cast<double>(close) / static_cast<double>(known);
  return overlap;
}

SurfaceOverlap CompareObjects(const TrackedObject& object,
                              const TrackedObject& other,
                              const Eigen::Isometry3d& T_other_object,
                              const SurfaceMatchParameters& parameters,
                              const VoxelScale& scale,
                              const Surroundings& surroundings) {
  const FreeSpaceSince* free_space = surroundings.free_space;
  const Eigen::Isometry3d T_world_other = other.state().T_world_object.ToIsometry();
  const auto is_in_free_space = [&](const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
    return free_space != nullptr &&
           IsInFreeSpace(T_world_other * point, T_world_other.linear() * normal, *free_space);
  };
  TsdfSampler sampler(other.volume(), scale);
  return Compare(
      object, T_other_object, parameters, is_in_free_space, surroundings.hidden, &sampler);
}

}  // namespace

double SurfaceSigmaM(const SurfaceMatchParameters& parameters, const VoxelScale& scale) {
  return std::hypot(parameters.place_sigma_m, parameters.surface_sigma_voxels * scale.voxel_size_m);
}

SurfaceOverlap CompareSurfaces(const TrackedObject& object,
                               const TrackedObject& other,
                               const Eigen::Isometry3d& T_other_object,
                               const SurfaceMatchParameters& parameters,
                               const VoxelScale& scale,
                               const FreeSpaceSince* free_space) {
  return CompareObjects(object, other, T_other_object, parameters, scale, {free_space});
}

SurfaceOverlap CompareWithBackground(const TrackedObject& object,
                                     const Background& background,
                                     const SurfaceMatchParameters& parameters,
                                     const VoxelScale& scale) {
  const auto is_in_free_space = [](const Eigen::Vector3d&, const Eigen::Vector3d&) {
    return false;
  };
  TsdfSampler sampler(background, scale);
  return Compare(object,
                 object.state().T_world_object.ToIsometry(),
                 parameters,
                 is_in_free_space,
                 HiddenSurface::kDisagrees,
                 &sampler);
}

MutualOverlap CompareInPlace(const TrackedObject& a,
                             const TrackedObject& b,
                             const SurfaceMatchParameters& parameters,
                             const VoxelScale& scale,
                             const FreeSpaceSince* free_space) {
  const Eigen::Isometry3d T_b_a =
      b.state().T_world_object.ToIsometry().inverse() * a.state().T_world_object.ToIsometry();
  const HiddenSurface hidden = HiddenSurface::kIsUnknown;
  return {CompareObjects(a, b, T_b_a, parameters, scale, {nullptr, hidden}),
          CompareObjects(b, a, T_b_a.inverse(), parameters, scale, {free_space, hidden})};
}

}  // namespace steadymap
