#include "core/map_counts.h"

namespace steadymap {

MapCounts CountMap(const MapSnapshot& snapshot) {
  MapCounts counts;
  counts.leaves = snapshot.background.leaf_count();
  counts.voxels = snapshot.background.CountObservedVoxels();
  counts.memory_bytes = VolumeBytes(snapshot);
  for (const auto& [id, object] : snapshot.objects) {
    if (object->standing == ObjectStanding::kArchived) ++counts.archived_objects;
    if (object->standing != ObjectStanding::kPresent) continue;
    ++counts.present_objects;
    counts.leaves += object->volume->leaf_count();
    counts.voxels += object->volume->CountObservedVoxels();
  }
  return counts;
}

std::size_t VolumeBytes(const MapSnapshot& snapshot) {
  std::size_t bytes = snapshot.background.memory_bytes();
  for (const auto& [id, object] : snapshot.objects) bytes += object->volume->memory_bytes();
  return bytes;
}

}  // namespace steadymap
