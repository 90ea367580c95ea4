#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>

#include "core/geometry/geometry.h"
#include "core/volume/tsdf_grid.h"

namespace steadymap {

/// Side of a background tile, voxels: 3.2 m at 5 cm. A shared tile is cloned before a write. A
/// larger tile copies more than the leaves changed by a frame; a smaller tile needs more tree
/// nodes.
inline constexpr int kTileSide = 64;

/// The surface of a map that belongs to no object. It is stored in tiles, fixed cubes of the world
/// lattice with one grid each. The grid frame of every tile is the world frame.
///
/// A copy shares the tiles. A tile shared with another copy is cloned before it is written, so a
/// published copy never changes.
class Background final : public VoxelReader {
 public:
  LeafView FindLeaf(LeafOrigin origin) const override;
  bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const override;
  std::size_t leaf_count() const override;

  /// Calls `visit` for each leaf of the tiles that intersect a box, metres; in the order of
  /// `VisitLeaves`. Cost: at most 0.1 us per tile of the box, and at most 10 ns per existing tile.
  void ForEachLeafNear(const Box& box_world,
                       const VoxelScale& scale,
                       const std::function<void(LeafOrigin, const LeafView&)>& visit) const;

  /// Returns `kLeafSide`, or up to `kTileSide`.
  int EmptySideAt(LeafOrigin origin) const override;

  /// Returns the tile that contains `origin`, for writing. Creates it if it does not exist, clones
  /// it if it is shared. Valid until the background is copied.
  TsdfGrid& MutableTile(LeafOrigin origin);

  /// The lowest voxel of a tile. Ordered, so that iteration is deterministic.
  struct TileOrigin {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    friend constexpr auto operator<=>(const TileOrigin&, const TileOrigin&) = default;
  };

  /// Returns the tiles by origin. While a tile is shared, it is never modified: equal pointers mean
  /// equal content.
  const std::map<TileOrigin, std::shared_ptr<TsdfGrid>>& tiles() const { return tiles_; }

  std::size_t tile_count() const { return tiles_.size(); }

  /// Returns the number of observed voxels of all tiles.
  std::size_t CountObservedVoxels() const;

  std::size_t memory_bytes() const;

 private:
  static TileOrigin TileOf(LeafOrigin origin);

  std::map<TileOrigin, std::shared_ptr<TsdfGrid>> tiles_;
};

}  // namespace steadymap
