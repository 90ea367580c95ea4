#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/geometry.h"
#include "core/types/query_work.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// Remembers where nothing was: cubes that a camera has looked through. Tells a thing that appears
/// where there was none from more of a thing that was known in part.
///
/// Kept in blocks of 8 x 8 x 8 cells, and these in tiles; grows only, by a bit a cell. Copying
/// shares the tiles; one that another copy shares is cloned before it is written.
class FreeSpace {
 public:
  /// Edge of a cell, metres, at a voxel size of 5 cm: two voxels.
  explicit FreeSpace(double cell_size_m) : cell_size_m_(cell_size_m) {}

  double cell_size_m() const { return cell_size_m_; }

  /// Whether the cell around a point was looked through.
  bool IsFree(const Eigen::Vector3d& point_world) const;

  /// How far the cells that a ray passes are free, from its start on, metres; `max_m` at most, and
  /// 0 if the first is not. `unit_direction` has length one, and the ray runs within 10^8 cells of
  /// the origin. Takes a step from `work` for each block on its way and ends where it may take
  /// none.
  double FreeRun(const Eigen::Vector3d& start_world,
                 const Eigen::Vector3d& unit_direction_world,
                 double max_m,
                 QueryWork* work) const;

  /// A box around all that is free, to the tile; empty if nothing is.
  Box Bounds() const;

  /// Bytes of the cells in memory.
  std::size_t memory_bytes() const { return tiles_.size() * sizeof(Tile); }

  /// Whether what lies right behind a surface that faces along the unit vector `normal_world` was
  /// looked through, so that the surface came after that. Nothing can be said of what is thinner
  /// than a cell.
  bool IsFreeBehind(const Eigen::Vector3d& point_world, const Eigen::Vector3d& normal_world) const;

  /// Marks the cells that the straight way from `from_world` to `to_world` passes; appends blocks
  /// that changed to `changed_blocks`, possibly with repetitions.
  void MarkRay(const Eigen::Vector3d& from_world,
               const Eigen::Vector3d& to_world,
               std::vector<LeafOrigin>* changed_blocks);

  /// The cells of the block whose lowest cell is `origin`; no bit set where there is no block.
  LeafMask FindBlock(LeafOrigin origin) const;

  /// Sets the cells of one block.
  void StoreBlock(LeafOrigin origin, const LeafMask& cells) { MutableBlock(origin) = cells; }

  /// Calls `visit` for each block with a free cell, in an order that depends on the content alone.
  void ForEachBlock(const std::function<void(LeafOrigin, const LeafMask&)>& visit) const;

  /// Whether both know the same cells.
  friend bool operator==(const FreeSpace& a, const FreeSpace& b);

 private:
  /// Blocks of a tile's side: 3.2 m at a voxel size of 5 cm.
  static constexpr int kTileBlocks = 4;
  static constexpr int kTileSide = kTileBlocks * kLeafSide;

  using Tile = std::array<LeafMask, std::size_t{kTileBlocks} * kTileBlocks * kTileBlocks>;

  static LeafOrigin TileOf(LeafOrigin block);
  static std::size_t PlaceInTile(LeafOrigin block);

  /// Valid until the next call.
  LeafMask& MutableBlock(LeafOrigin origin);

  double cell_size_m_;
  std::map<LeafOrigin, std::shared_ptr<Tile>> tiles_;  ///< By the lowest cell.
};

}  // namespace steadymap
