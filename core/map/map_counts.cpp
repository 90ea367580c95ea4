#include "core/map/map_counts.h"

#include <utility>

namespace steadymap {

MapCounts MapCounter::Count(const MapSnapshot& snapshot) {
  MapCounts counts;
  const auto add = [&counts](const CountedVolume& volume, bool is_shown) {
    counts.memory_bytes += volume.memory_bytes;
    if (!is_shown) return;
    counts.leaves += volume.leaves;
    counts.voxels += volume.voxels;
  };
  // Entries of volumes that no longer exist stay in the old table and are freed with it.
  std::map<Background::TileOrigin, CountedVolume> tiles;
  for (const auto& [origin, tile] : snapshot.background.tiles()) {
    CountedVolume& counted = tiles[origin] = std::move(tiles_[origin]);
    Update(tile, &counted);
    add(counted, /*is_shown=*/true);
  }
  tiles_ = std::move(tiles);
  std::map<ObjectId, CountedVolume> objects;
  for (const auto& [id, object] : snapshot.objects) {
    CountedVolume& counted = objects[id] = std::move(objects_[id]);
    Update(object->volume, &counted);
    counts.memory_bytes += object->evidence.leaves.capacity() * sizeof(LeafEvidence);
    for (const SessionLooks& looks : object->looks) {
      counts.memory_bytes += looks.leaves.capacity() * sizeof(LeafEvidence);
    }
    const bool is_present = object->status == ObjectStatus::kPresent;
    add(counted, is_present);
    counts.present_objects += is_present ? 1 : 0;
    counts.archived_objects += object->status == ObjectStatus::kArchived ? 1 : 0;
  }
  objects_ = std::move(objects);
  counts.memory_bytes += snapshot.free_space.memory_bytes();
  return counts;
}

void MapCounter::Update(const std::shared_ptr<const TsdfGrid>& volume, CountedVolume* counted) {
  if (counted->volume == volume) return;
  *counted = {volume, volume->leaf_count(), volume->CountObservedVoxels(), volume->memory_bytes()};
}

}  // namespace steadymap
