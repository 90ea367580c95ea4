#pragma once

#include <map>
#include <vector>

#include <Eigen/Core>

#include "core/voxel_leaf.h"

namespace steadymap {

/// Remembers where nothing was: cubes that a camera has looked through. Tells a thing that appears
/// where there was none from more of a thing that was known in part.
///
/// Kept in blocks of 8 x 8 x 8 cells; grows only.
class FreeSpace {
 public:
  /// Edge of a cell, metres, at a voxel size of 5 cm: two voxels.
  explicit FreeSpace(double cell_size_m) : cell_size_m_(cell_size_m) {}

  double cell_size_m() const { return cell_size_m_; }

  /// Whether the cell around a point was looked through.
  bool IsFree(const Eigen::Vector3d& point_world) const;

  /// Marks the cells that the straight way from `from_world` to `to_world` passes; appends blocks
  /// that changed to `changed_blocks`, possibly with repetitions.
  void MarkRay(const Eigen::Vector3d& from_world,
               const Eigen::Vector3d& to_world,
               std::vector<LeafOrigin>* changed_blocks);

  /// The cells of each block, by the index of its lowest cell.
  const std::map<LeafOrigin, LeafMask>& blocks() const { return blocks_; }

  /// Sets the cells of one block.
  void StoreBlock(LeafOrigin origin, const LeafMask& cells) { blocks_[origin] = cells; }

  friend bool operator==(const FreeSpace&, const FreeSpace&) = default;

 private:
  double cell_size_m_;
  std::map<LeafOrigin, LeafMask> blocks_;
};

}  // namespace steadymap
