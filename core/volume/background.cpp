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
