#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/volume/tsdf_grid.h"
#include "tests/support/analytic_depth.h"

namespace steadymap::testing {

/// A solid made of boxes, object frame, metres. Adjacent boxes should overlap by more than a
/// truncation distance; otherwise their common face counts as surface.
using Solid = std::vector<Box>;

/// Returns the signed distance from a solid, positive outside; exact outside.
inline double DistanceFrom(const Solid& solid, const Eigen::Vector3d& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const Box& box : solid) {
    const Eigen::Vector3d beyond =
        (point - box.center()).cwiseAbs() - 0.5 * Eigen::Vector3d(box.sizes());
    const double outside = beyond.cwiseMax(0.0).norm();
    least = std::min(least, outside + std::min(beyond.maxCoeff(), 0.0));
  }
  return least;
}

/// Returns the range at which a ray first enters a solid, in multiples of its direction; NaN
/// without a hit.
inline RangeFunction RangeTo(const Solid& solid) {
  return [solid](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
    double nearest = std::nan("");
    for (const Box& box : solid) {
      const Eigen::Array3d a = (box.min() - origin).array() / direction.array();
      const Eigen::Array3d b = (box.max() - origin).array() / direction.array();
      const double enter = a.min(b).maxCoeff();
      const double leave = a.max(b).minCoeff();
      if (enter <= 0.0 || enter > leave) continue;
      if (!(nearest <= enter)) nearest = enter;
    }
    return nearest;
  };
}

/// Test objects with their base at z = 0.
inline Solid Crate() {
  return {Box(Eigen::Vector3d(-0.25, -0.35, 0), Eigen::Vector3d(0.25, 0.35, 1))};
}

inline Solid CrateWithParcel() {
  return {Box(Eigen::Vector3d(-0.3, -0.4, 0), Eigen::Vector3d(0.3, 0.4, 0.5)),
          Box(Eigen::Vector3d(-0.2, -0.1, 0.2), Eigen::Vector3d(0.15, 0.3, 0.8))};
}

inline Solid Angle() {
  return {Box(Eigen::Vector3d(-0.4, -0.4, 0), Eigen::Vector3d(0.4, -0.1, 0.6)),
          Box(Eigen::Vector3d(-0.4, -0.4, 0), Eigen::Vector3d(-0.1, 0.4, 0.6))};
}

/// All test objects.
inline std::vector<Solid> ThingsToLookAt() { return {Crate(), CrateWithParcel(), Angle()}; }

/// Returns a voxel with a weight of one at a distance from the surface, metres.
inline Voxel VoxelWithDistance(double distance_m, const VoxelScale& scale) {
  const long steps = std::lround(distance_m / static_cast<double>(scale.distance_step_m()));
  return {static_cast<int>(steps), static_cast<int>(1.0F / kWeightUnit)};
}

/// Returns one leaf of a solid's volume: the voxels within the truncation distance of the surface
/// for which `is_observed` is true.
inline LeafVoxels MakeLeaf(const LeafOrigin& origin,
                           const std::function<double(const Eigen::Vector3d&)>& distance_m,
                           const VoxelScale& scale,
                           const std::function<bool(const Eigen::Vector3d&)>& is_observed) {
  LeafVoxels leaf;
  for (std::size_t offset = 0; offset < kLeafVoxels; ++offset) {
    const Eigen::Vector3i voxel(origin.x + static_cast<int>(offset >> 6),
                                origin.y + static_cast<int>((offset >> 3) & 7),
                                origin.z + static_cast<int>(offset & 7));
    const Eigen::Vector3d center_m = voxel.cast<double>() * scale.voxel_size_m;
    const double distance = distance_m(center_m);
    if (std::abs(distance) > scale.truncation_m || !is_observed(center_m)) continue;
    leaf.voxels[offset] = VoxelWithDistance(distance, scale);
    SetBit(offset, &leaf.observed);
  }
  return leaf;
}

/// Returns the volume of a solid within `bounds`.
inline TsdfGrid MakeVolume(const std::function<double(const Eigen::Vector3d&)>& distance_m,
                           const Box& bounds,
                           const VoxelScale& scale,
                           const std::function<bool(const Eigen::Vector3d&)>& is_observed) {
  TsdfGrid volume;
  const auto leaf_at = [&](const Eigen::Vector3d& point_m) {
    const Eigen::Vector3d voxel = (point_m / scale.voxel_size_m).array().floor();
    const Eigen::Vector3i index = voxel.cast<std::int32_t>();
    return LeafOf(index.x(), index.y(), index.z());
  };
  const LeafOrigin low = leaf_at(bounds.min());
  const LeafOrigin high = leaf_at(bounds.max());
  for (std::int32_t x = low.x; x <= high.x; x += kLeafSide) {
    for (std::int32_t y = low.y; y <= high.y; y += kLeafSide) {
      for (std::int32_t z = low.z; z <= high.z; z += kLeafSide) {
        const LeafVoxels leaf = MakeLeaf({x, y, z}, distance_m, scale, is_observed);
        if (leaf.observed != LeafMask{}) volume.StoreLeaf({x, y, z}, leaf);
      }
    }
  }
  return volume;
}

/// Returns the volume of what `is_observed` of a solid within bounds, all in the world frame, in a
/// grid with its origin at `origin_world`.
inline TsdfGrid MakeVolumeAt(const Eigen::Vector3d& origin_world,
                             const Solid& solid_world,
                             const Box& bounds_world,
                             const VoxelScale& scale,
                             const std::function<bool(const Eigen::Vector3d&)>& is_observed) {
  return MakeVolume(
      [&](const Eigen::Vector3d& point) { return DistanceFrom(solid_world, point + origin_world); },
      Box(bounds_world.min() - origin_world, bounds_world.max() - origin_world),
      scale,
      [&](const Eigen::Vector3d& point) { return is_observed(point + origin_world); });
}

/// Returns the volume of a solid on the floor: voxels below z = 0 are not observed.
inline TsdfGrid MakeVolume(const Solid& solid, const VoxelScale& scale) {
  Box bounds;
  for (const Box& box : solid) bounds.extend(box);
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(scale.truncation_m);
  return MakeVolume([&](const Eigen::Vector3d& point) { return DistanceFrom(solid, point); },
                    Box(bounds.min() - margin, bounds.max() + margin),
                    scale,
                    [](const Eigen::Vector3d& point) { return point.z() >= 0.0; });
}

/// Returns a copy of a volume with another weight of all observed voxels.
inline TsdfGrid WithWeight(const TsdfGrid& volume, float weight) {
  TsdfGrid copy;
  volume.ForEachLeaf([&](LeafOrigin origin, const LeafView& leaf) {
    LeafVoxels voxels;
    CopyLeaf(leaf, &voxels);
    ForEachBit(voxels.observed, [&](std::size_t offset) {
      const int units = static_cast<int>(weight / kWeightUnit);
      voxels.voxels[offset] = {voxels.voxels[offset].distance_steps(), units};
    });
    copy.StoreLeaf(origin, voxels);
  });
  return copy;
}

/// The visible surface points of one view from `eye` to `target`, one every `spacing_rad`.
struct SurfaceView {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> directions;  ///< Unit, from the eye to each point.
};

inline SurfaceView LookAtSurface(const RangeFunction& surface,
                                 const Eigen::Vector3d& eye,
                                 const Eigen::Vector3d& target,
                                 double spacing_rad) {
  constexpr double kHalfViewRad = 0.45;
  const Eigen::Isometry3d T_object_camera = LookAt(eye, target);
  const int a_side = static_cast<int>(kHalfViewRad / spacing_rad);
  SurfaceView view;
  for (int v = -a_side; v <= a_side; ++v) {
    for (int u = -a_side; u <= a_side; ++u) {
      const Eigen::Vector3d direction =
          T_object_camera.linear() *
          Eigen::Vector3d(u * spacing_rad, v * spacing_rad, 1.0).normalized();
      const double range_m = surface(eye, direction);
      if (!(range_m > 0.0)) continue;
      view.points.emplace_back(eye + range_m * direction);
      view.directions.push_back(direction);
    }
  }
  return view;
}

/// Returns views of an object on the floor from all sides and from above, so that three sides of a
/// box are visible (azimuths keep 15 degrees distance from the axes).
inline std::vector<SurfaceView> LooksAround(const Solid& solid, double spacing_rad) {
  std::vector<SurfaceView> views;
  constexpr double kDegree = std::numbers::pi / 180.0;
  const RangeFunction surface = RangeTo(solid);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    for (const double within_deg : {15.0, 35.0, 55.0, 75.0}) {
      const double azimuth = (90.0 * quadrant + within_deg) * kDegree;
      for (const double height_m : {1.6, 2.2}) {
        const Eigen::Vector3d eye(1.8 * std::cos(azimuth), 1.8 * std::sin(azimuth), height_m);
        views.push_back(LookAtSurface(surface, eye, {0.0, 0.0, 0.4}, spacing_rad));
      }
    }
  }
  return views;
}

/// Returns the points of a view with noise along their rays.
inline std::vector<Eigen::Vector3d> WithNoise(const SurfaceView& view,
                                              double noise_m,
                                              std::mt19937_64* random) {
  std::normal_distribution<double> noise(0.0, noise_m);
  std::vector<Eigen::Vector3d> points = view.points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += noise(*random) * view.directions[i];
  return points;
}

/// Returns a rotation about a vertical axis through a point, followed by a shift.
inline Eigen::Isometry3d UprightMotionAbout(const Eigen::Vector3d& pivot,
                                            const Eigen::Vector3d& shift_m,
                                            double yaw_rad) {
  return Eigen::Translation3d(pivot + shift_m) *
         Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(-pivot);
}

/// Returns a uniformly random direction times a uniformly random length up to `max_length`.
inline Eigen::Vector3d RandomShift(double max_length, std::mt19937_64* random) {
  std::normal_distribution<double> component;
  std::uniform_real_distribution<double> length(0.0, max_length);
  const Eigen::Vector3d direction(component(*random), component(*random), component(*random));
  return length(*random) * direction.normalized();
}

/// Returns a random upright motion about a point by up to 15 cm and 8 degrees: the required
/// convergence range of the registration.
inline Eigen::Isometry3d RandomMotionAbout(const Eigen::Vector3d& pivot, std::mt19937_64* random) {
  constexpr double kMaxShiftM = 0.15;
  constexpr double kMaxYawRad = 8.0 * std::numbers::pi / 180.0;
  std::uniform_real_distribution<double> yaw(-kMaxYawRad, kMaxYawRad);
  const Eigen::Vector3d shift_m = RandomShift(kMaxShiftM, random);
  return UprightMotionAbout(pivot, shift_m, yaw(*random));
}

}  // namespace steadymap::testing
