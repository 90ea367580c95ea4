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
#include "core/types/timestamp.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// When a ray was measured.
struct RayTime {
  Timestamp session_start;  ///< Of the session that measured it.
  Timestamp time;
};

/// The free cells of one block of 8 x 8 x 8.
struct FreeBlock {
  LeafMask cells{};          ///< Seen free at any time.
  LeafMask recent{};         ///< Of `cells`: seen free since `recent_since`.
  Timestamp recent_since{};  ///< Latest start of a session that looked through the block.

  friend bool operator==(const FreeBlock&, const FreeBlock&) = default;
};

/// The set of free cells: cubes through which a camera has observed a surface. It separates a new
/// object, which appears in free space, from a newly observed part of a known object.
///
/// Cells are stored as bits in blocks of 8 x 8 x 8, and blocks in tiles. The set only grows; which
/// of its cells the latest session looked through is kept beside it. A copy shares the tiles; a
/// tile shared with another copy is cloned before it is written.
class FreeSpace {
 public:
  /// `cell_size_m` is the edge length of a cell, metres.
  explicit FreeSpace(double cell_size_m) : cell_size_m_(cell_size_m) {}

  double cell_size_m() const { return cell_size_m_; }

  /// True if the cell that contains the point is free.
  bool IsFree(const Eigen::Vector3d& point_world) const;

  /// True if the cell that contains the point was seen free at or after `time`. Also false if only
  /// sessions that started before `time` have looked through the block since, or if a later one
  /// did and missed the cell.
  bool IsFreeSince(const Eigen::Vector3d& point_world, Timestamp time) const;

  /// Returns the length of the free part of a ray from its start, metres: at most `max_m`, 0 if the
  /// first cell is not free. `unit_direction_world` has length one, and the ray lies within 10^8
  /// cells of the origin. Takes one step from `work` per block, and ends early if `work` is
  /// exhausted.
  double FreeRun(const Eigen::Vector3d& start_world,
                 const Eigen::Vector3d& unit_direction_world,
                 double max_m,
                 QueryWork* work) const;

  /// Returns a box around all free cells, rounded to whole tiles; empty if there are none.
  Box Bounds() const;

  /// Returns the memory of the tiles, bytes.
  std::size_t memory_bytes() const { return tiles_.size() * sizeof(Tile); }

  /// Marks the cells on the segment from `from_world` to `to_world`. Appends the changed blocks to
  /// `changed_blocks`, possibly with duplicates.
  void MarkRay(const Eigen::Vector3d& from_world,
               const Eigen::Vector3d& to_world,
               const RayTime& ray_time,
               std::vector<LeafOrigin>* changed_blocks);

  /// Returns the block with lowest cell `origin`; no bit is set if there is none.
  FreeBlock FindBlock(LeafOrigin origin) const;

  /// Replaces one block.
  void StoreBlock(LeafOrigin origin, const FreeBlock& block) { MutableBlock(origin) = block; }

  /// Calls `visit` for each block with a free cell, in an order that depends only on the content.
  void ForEachBlock(const std::function<void(LeafOrigin, const FreeBlock&)>& visit) const;

  /// True if the free cells and the cell sizes are equal.
  friend bool operator==(const FreeSpace& a, const FreeSpace& b);

 private:
  /// Blocks per tile side: 3.2 m at a voxel size of 5 cm.
  static constexpr int kTileBlocks = 4;
  static constexpr int kTileSide = kTileBlocks * kLeafSide;

  using Tile = std::array<FreeBlock, std::size_t{kTileBlocks} * kTileBlocks * kTileBlocks>;

  static LeafOrigin TileOf(LeafOrigin block);
  static std::size_t PlaceInTile(LeafOrigin block);

  /// Returns a block for writing; valid until the next call.
  FreeBlock& MutableBlock(LeafOrigin origin);

  double cell_size_m_;
  std::map<LeafOrigin, std::shared_ptr<Tile>> tiles_;  ///< By the lowest cell.
};

/// What was seen free at or after a time. The free space must outlive it.
class FreeSpaceSince {
 public:
  FreeSpaceSince(const FreeSpace& free_space, Timestamp time)
      : free_space_(free_space), time_(time) {}

  double cell_size_m() const { return free_space_.cell_size_m(); }

  /// See `FreeSpace::IsFreeSince`.
  bool IsFree(const Eigen::Vector3d& point_world) const {
    return free_space_.IsFreeSince(point_world, time_);
  }

 private:
  const FreeSpace& free_space_;
  Timestamp time_;
};

}  // namespace steadymap
