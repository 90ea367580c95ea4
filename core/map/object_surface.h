#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Side of an evidence cell, voxels. Cells are the units of presence and absence evidence: smaller
/// than any relevant change, and large enough that a few pixels decide.
inline constexpr int kEvidenceSide = 2;

/// Number of evidence cells of a leaf.
inline constexpr std::size_t kEvidenceCells = 64;

/// Returns the index of the evidence cell that contains the voxel at `offset` of its leaf.
constexpr std::uint8_t EvidenceCellOf(std::size_t offset) {
  return static_cast<std::uint8_t>(((offset >> 7) & 3) << 4 | ((offset >> 4) & 3) << 2 |
                                   ((offset >> 1) & 3));
}

/// A surface point of an object, one per voxel on the surface.
struct SurfaceVoxel {
  /// Returns the index of its evidence cell in the leaf.
  std::uint8_t cell() const { return EvidenceCellOf(offset); }

  Eigen::Vector3f position_object;  ///< Metres.
  Eigen::Vector3f normal_object;    ///< Unit length, towards the observed side.
  std::uint16_t offset = 0;         ///< Of its voxel in the leaf.
};

/// The surface points of one leaf.
struct SurfaceLeaf {
  LeafOrigin origin;
  std::vector<SurfaceVoxel> points;
};

/// The surface points of an object, a function of its volume alone.
class ObjectSurface {
 public:
  /// Recomputes the points of the leaves in `origins`.
  void Update(const TsdfGrid& volume, const VoxelScale& scale, std::span<const LeafOrigin> origins);

  /// Recomputes all points.
  void Rebuild(const TsdfGrid& volume, const VoxelScale& scale);

  /// Returns the leaves with surface, by increasing origin.
  const std::vector<SurfaceLeaf>& leaves() const { return leaves_; }

  std::size_t point_count() const;

  /// Returns the memory of points and leaves, bytes.
  std::size_t memory_bytes() const {
    return leaves_.capacity() * sizeof(SurfaceLeaf) + point_bytes_;
  }

 private:
  std::vector<SurfaceLeaf> leaves_;
  std::size_t point_bytes_ = 0;  ///< Of all leaves.
};

}  // namespace steadymap
