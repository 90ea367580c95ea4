#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

#include <Eigen/Core>

namespace steadymap {

/// A voxel of the scoring grid, independent of the map's own voxels. Its centre is its index times
/// the voxel size, world frame, so a floor at z = 0 runs through the centres of voxels and not
/// along their faces.
struct VoxelIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const VoxelIndex&, const VoxelIndex&) = default;
};

/// Returns the voxel of edge `voxel_size_m` that contains a point.
inline VoxelIndex VoxelAt(const Eigen::Vector3f& point_world, double voxel_size_m) {
  const Eigen::Vector3f index =
      (point_world / static_cast<float>(voxel_size_m)).array().round().matrix();
  return {static_cast<std::int32_t>(index.x()),
          static_cast<std::int32_t>(index.y()),
          static_cast<std::int32_t>(index.z())};
}

/// Returns the centre of a voxel, world frame, metres.
inline Eigen::Vector3f CenterOf(const VoxelIndex& voxel, double voxel_size_m) {
  return Eigen::Vector3i(voxel.x, voxel.y, voxel.z).cast<float>() *
         static_cast<float>(voxel_size_m);
}

}  // namespace steadymap

template <>
struct std::hash<steadymap::VoxelIndex> {
  std::size_t operator()(const steadymap::VoxelIndex& voxel) const noexcept {
    const auto mix = [](std::uint64_t value) { return value * 0x9E3779B97F4A7C15ULL; };
    std::uint64_t mixed = mix(static_cast<std::uint32_t>(voxel.x));
    mixed = mix(mixed ^ static_cast<std::uint32_t>(voxel.y));
    mixed = mix(mixed ^ static_cast<std::uint32_t>(voxel.z));
    return static_cast<std::size_t>(mixed ^ (mixed >> 32));
  }
};
