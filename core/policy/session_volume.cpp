#include "core/policy/session_volume.h"

#include <algorithm>
#include <cmath>

#include "core/volume/background.h"

namespace steadymap {
namespace {

constexpr double kStampGrainS = 1.0;

std::int32_t LowestVoxel(double position_m, const VoxelScale& scale) {
  return static_cast<std::int32_t>(std::lround(position_m / scale.voxel_size_m));
}

}  // namespace

SessionVolume::SessionVolume(WorkingMap* map) : map_(*map) {
  for (TrackedObject* object : map->TentativeObjects()) {
    const Eigen::Vector3d& corner_world = object->state().T_world_object.position_world;
    const LeafOrigin tile{LowestVoxel(corner_world.x(), map->scale()),
                          LowestVoxel(corner_world.y(), map->scale()),
                          LowestVoxel(corner_world.z(), map->scale())};
    tiles_.emplace(tile, object);
    last_fused_ = std::max(last_fused_, object->state().last_seen);
  }
}

SessionVolume::Place SessionVolume::PlaceOf(LeafOrigin origin) {
  constexpr std::int32_t kInTile = kTileSide - 1;
  return {{origin.x & ~kInTile, origin.y & ~kInTile, origin.z & ~kInTile},
          {origin.x & kInTile, origin.y & kInTile, origin.z & kInTile}};
}

LeafView SessionVolume::FindLeaf(LeafOrigin origin) const {
  const Place place = PlaceOf(origin);
  const auto tile = tiles_.find(place.tile);
  return tile == tiles_.end() ? LeafView{} : tile->second->volume().FindLeaf(place.origin);
}

bool SessionVolume::VisitLeaves(
    const std::function<bool(LeafOrigin, const LeafView&)>& visit) const {
  return std::all_of(tiles_.begin(), tiles_.end(), [&visit](const auto& tile) {
    const LeafOrigin low = tile.first;
    return tile.second->volume().VisitLeaves([&](LeafOrigin origin, const LeafView& leaf) {
      return visit({low.x + origin.x, low.y + origin.y, low.z + origin.z}, leaf);
    });
  });
}

std::size_t SessionVolume::leaf_count() const {
  std::size_t count = 0;
  for (const auto& [corner, tile] : tiles_) count += tile->volume().leaf_count();
  return count;
}

TrackedObject* SessionVolume::TileAt(LeafOrigin tile) {
  const auto known = tiles_.find(tile);
  if (known != tiles_.end()) return known->second;
  const Eigen::Vector3d corner_world =
      Eigen::Vector3d(tile.x, tile.y, tile.z) * map_.scale().voxel_size_m;
  TrackedObject* object = &map_.AddObject(corner_world);
  tiles_.emplace(tile, object);
  return object;
}

void SessionVolume::Fuse(TsdfIntegrator* integrator) {
  const auto place_of = [this](LeafOrigin origin) {
    const Place place = PlaceOf(origin);
    return ObjectLeaf{TileAt(place.tile), place.origin};
  };
  for (TrackedObject* tile : map_.FuseTiles(place_of, integrator)) Stamp(tile);
  if (tiles_.empty() || (map_.now() - last_fused_).seconds() < kStampGrainS) return;
  // The visit goes on, though nothing changes any more.
  Stamp(tiles_.begin()->second);
}

void SessionVolume::StoreLeaf(LeafOrigin origin, const LeafVoxels& voxels) {
  const Place place = PlaceOf(origin);
  TrackedObject* tile = TileAt(place.tile);
  {
    ObjectEdit edit = map_.Edit(tile);
    edit.StoreLeaf(place.origin, voxels);
  }
  Stamp(tile);
}

/// Notes that a tile was fused into now.
void SessionVolume::Stamp(TrackedObject* tile) {
  ObjectEdit edit = map_.Edit(tile);
  edit.state().last_seen = map_.now();
  last_fused_ = map_.now();
}

void SessionVolume::Discard() {
  for (const auto& [corner, tile] : tiles_) map_.Delete(tile);
  tiles_.clear();
}

}  // namespace steadymap
