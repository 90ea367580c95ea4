#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>

#include <Eigen/Core>

namespace steadymap {

/// A voxel of the lattice that maps are scored on, whatever voxels the map itself has. Its centre
/// lies at its index times the voxel size, world frame: a floor at z = 0 runs through the middle of
/// voxels, not along their border.
struct VoxelIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const VoxelIndex&, const VoxelIndex&) = default;
};

/// The voxel of edge `voxel_size_m` that holds a point.
inline VoxelIndex VoxelAt(const Eigen::Vector3f& point_world, double voxel_size_m) {
  const Eigen::Vector3f index =
      (point_world / static_cast<float>(voxel_size_m)).array().round().matrix();
  return {static_cast<std::int32_t>(index.x()),
          static_cast<std::int32_t>(index.y()),
          static_cast<std::int32_t>(index.z())};
}

/// The middle of a voxel, world frame, metres.
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
