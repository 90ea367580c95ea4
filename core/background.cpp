#include "core/background.h"

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

void Background::ForEachLeaf(const std::function<void(LeafOrigin, const LeafView&)>& visit) const {
  for (const auto& [origin, tile] : tiles_) tile->ForEachLeaf(visit);
}

std::size_t Background::leaf_count() const {
  std::size_t count = 0;
  for (const auto& [origin, tile] : tiles_) count += tile->leaf_count();
  return count;
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
