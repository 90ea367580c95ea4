#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <unordered_map>

#include "client/bench/evaluation/truth/depth_view.h"
#include "client/bench/evaluation/truth/voxel_index.h"

namespace steadymap {

/// The voxels that a run observed: those its rays passed through or ended in.
class ObservedSpace {
 public:
  /// Voxels have the edge `voxel_size_m`; rays end at the depth `max_depth_m`; all > 0.
  ObservedSpace(double voxel_size_m, double max_depth_m);
  ObservedSpace(ObservedSpace&&) = default;
  ObservedSpace& operator=(ObservedSpace&&) = default;

  /// Casts rays through a grid of the picture's pixels, dense enough to miss no voxel within range.
  /// A ray starts at the camera and ends at the voxel with the surface. Pixels of depth 0 are
  /// ignored; a ray of infinite depth is free up to `max_depth_m`. Cost: about 20 ns per voxel
  /// crossed.
  void AddView(const DepthView& view);

  double voxel_size_m() const { return voxel_size_m_; }

  bool IsObserved(const VoxelIndex& voxel) const;

  /// Number of voxels observed so far.
  std::size_t observed_count() const;

  /// Calls `visit` for every observed voxel, in no particular order.
  void ForEach(const std::function<void(const VoxelIndex&)>& visit) const;

 private:
  static constexpr int kBlockSide = 8;
  static constexpr std::size_t kBlockVoxels = 512;
  using Block = std::array<std::uint8_t, kBlockVoxels>;

  void MarkObserved(const VoxelIndex& voxel);
  void CastRay(const Eigen::Vector3d& from_world, const Eigen::Vector3d& to_world);

  double voxel_size_m_;
  double max_depth_m_;
  std::unordered_map<VoxelIndex, Block> blocks_;  ///< By voxel index / kBlockSide.
  VoxelIndex last_index_;                         ///< Of `last_block_`.
  Block* last_block_ = nullptr;  ///< Cache: successive voxels of a ray share a block.
};

}  // namespace steadymap
