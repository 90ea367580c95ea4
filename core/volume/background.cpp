#include "core/volume/background.h"

#include <algorithm>

namespace steadymap {

Background::TileOrigin Background::TileOf(LeafOrigin origin) {
  static_assert((kTileSide & (kTileSide - 1)) == 0, "the mask below needs a power of two");
  constexpr std::int32_t kTileMask = ~(kTileSide - 1);
  return {origin.x & kTileMask, origin.y & kTileMask, origin.z & kTileMask};
}

LeafView Background::FindLeaf(LeafOrigin origin) const {
  const auto tile = tiles_.find(TileOf(origin));
  return tile == tiles_.end() ? LeafView{} : tile->second->FindLeaf(origin);
}

bool Background::VisitLeaves(const std::function<bool(LeafOrigin, const LeafView&)>& visit) const {
  return std::all_of(tiles_.begin(), tiles_.end(), [&visit](const auto& tile) {
    return tile.second->VisitLeaves(visit);
  });
}

std::size_t Background::leaf_count() const {
  std::size_t count = 0;
  for (const auto& [origin, tile] : tiles_) count += tile->leaf_count();
  return count;
}

void Background::ForEachLeafNear(
    const Box& box_world,
    const VoxelScale& scale,
    const std::function<void(LeafOrigin, const LeafView&)>& visit) const {
  // In tiles, which extend by half a voxel below the centre of their lowest voxel.
  const double tile_size_m = kTileSide * scale.voxel_size_m;
  const double offset = 0.5 / kTileSide;
  const Eigen::Array3d low = (box_world.min().array() / tile_size_m + offset).floor();
  const Eigen::Array3d high = (box_world.max().array() / tile_size_m + offset).floor();
  if (!((high - low + 1.0).prod() < static_cast<double>(tiles_.size()))) {
    for (const auto& [origin, tile] : tiles_) {
      const Eigen::Array3d index = Eigen::Array3d(origin.x, origin.y, origin.z) / kTileSide;
      if ((index >= low).all() && (index <= high).all()) tile->ForEachLeaf(visit);
    }
    return;
  }
  const Eigen::Array3i first = low.cast<int>() * kTileSide;
  const Eigen::Array3i last = high.cast<int>() * kTileSide;
  for (int x = first.x(); x <= last.x(); x += kTileSide) {
    for (int y = first.y(); y <= last.y(); y += kTileSide) {
      for (int z = first.z(); z <= last.z(); z += kTileSide) {
        const auto tile = tiles_.find({x, y, z});
        if (tile != tiles_.end()) tile->second->ForEachLeaf(visit);
      }
    }
  }
}

int Background::EmptySideAt(LeafOrigin origin) const {
  const auto tile = tiles_.find(TileOf(origin));
  return tile == tiles_.end() ? kTileSide : std::min(kTileSide, tile->second->EmptySideAt(origin));
}

TsdfGrid& Background::MutableTile(LeafOrigin origin) {
  std::shared_ptr<TsdfGrid>& tile = tiles_[TileOf(origin)];
  if (tile == nullptr) {
    tile = std::make_shared<TsdfGrid>();
  } else if (tile.use_count() > 1) {
    tile = tile->Clone();
  }
  return *tile;
}

std::size_t Background::CountObservedVoxels() const {
  std::size_t count = 0;
  for (const auto& [origin, tile] : tiles_) count += tile->CountObservedVoxels();
  return count;
}

std::size_t Background::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& [origin, tile] : tiles_) bytes += tile->memory_bytes();
  return bytes;
}

}  // namespace steadymap
