#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>

#include "core/volume/tsdf_grid.h"

namespace steadymap {

/// Side of a background tile, voxels: 3.2 m at 5 cm. A tile is what is cloned before a write, so
/// larger tiles copy more than a frame touches and smaller ones cost more tree nodes.
inline constexpr int kTileSide = 64;

/// The part of a map that belongs to no object, kept in tiles: fixed cubes of the world lattice,
/// each a grid of its own (decisions.md 5). The grid frame of every tile is the world frame.
///
/// Copying shares the tiles. A tile that another copy shares is cloned before it is written, so a
/// published copy never changes (decisions.md 6).
class Background final : public VoxelReader {
 public:
  LeafView FindLeaf(LeafOrigin origin) const override;
  bool VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const override;
  std::size_t leaf_count() const override;

  /// A leaf or a tile.
  int EmptySideAt(LeafOrigin origin) const override;

  /// The tile that holds `origin`, created or cloned if need be, for writing. Valid until the
  /// background is copied.
  TsdfGrid& MutableTile(LeafOrigin origin);

  /// Lowest voxel of a tile; ordered, so that iteration is deterministic.
  struct TileOrigin {
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    friend constexpr auto operator<=>(const TileOrigin&, const TileOrigin&) = default;
  };

  /// The tiles, each the same object as long as it does not change and is held by somebody else.
  const std::map<TileOrigin, std::shared_ptr<TsdfGrid>>& tiles() const { return tiles_; }

  std::size_t tile_count() const { return tiles_.size(); }

  /// Observed voxels of all tiles.
  std::size_t CountObservedVoxels() const;

  std::size_t memory_bytes() const;

 private:
  static TileOrigin TileOf(LeafOrigin origin);

  std::map<TileOrigin, std::shared_ptr<TsdfGrid>> tiles_;
};

}  // namespace steadymap
