#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Presence and absence are judged by cubes of this many voxels a side: finer than any change that
/// matters, coarse enough that a few pixels decide.
inline constexpr int kEvidenceSide = 2;

/// Evidence cells of a leaf.
inline constexpr std::size_t kEvidenceCells = 64;

/// A point of an object's surface, one a voxel that the surface passes.
struct SurfaceVoxel {
  Eigen::Vector3f position_object;  ///< Metres.
  Eigen::Vector3f normal_object;    ///< Unit, towards the side that was observed.
  std::uint8_t cell = 0;            ///< Evidence cell of its leaf.
};

/// The surface points of one leaf.
struct SurfaceLeaf {
  LeafOrigin origin;
  std::vector<SurfaceVoxel> points;
};

/// The surface of an object as points, kept beside its volume. A function of the volume alone.
class ObjectSurface {
 public:
  /// Takes the points of the leaves in `origins` anew.
  void Update(const TsdfGrid& volume, const VoxelScale& scale, std::span<const LeafOrigin> origins);

  /// Takes all points anew.
  void Rebuild(const TsdfGrid& volume, const VoxelScale& scale);

  /// By rising origin; leaves without surface are left out.
  const std::vector<SurfaceLeaf>& leaves() const { return leaves_; }

  std::size_t point_count() const;

  /// Bytes of the points and their leaves.
  std::size_t memory_bytes() const {
    return leaves_.capacity() * sizeof(SurfaceLeaf) + point_bytes_;
  }

 private:
  std::vector<SurfaceLeaf> leaves_;
  std::size_t point_bytes_ = 0;  ///< Of all leaves.
};

/// Evidence cell of the voxel at `offset` of its leaf.
constexpr std::uint8_t EvidenceCellOf(std::size_t offset) {
  return static_cast<std::uint8_t>(((offset >> 7) & 3) << 4 | ((offset >> 4) & 3) << 2 |
                                   ((offset >> 1) & 3));
}

}  // namespace steadymap
