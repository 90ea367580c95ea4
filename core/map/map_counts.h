#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include "core/map/map_snapshot.h"

namespace steadymap {

/// Sizes of a map.
struct MapCounts {
  std::size_t present_objects = 0;
  std::size_t archived_objects = 0;
  std::size_t leaves = 0;  ///< Of background and present objects.
  std::size_t voxels = 0;  ///< Observed voxels of background and present objects.
  /// Bytes in memory: volumes of the background and of objects of every status, evidence of
  /// objects, and free space.
  std::size_t memory_bytes = 0;

  friend bool operator==(const MapCounts&, const MapCounts&) = default;
};

/// Counts the snapshots of one map incrementally: caches the counts of unchanged volumes. One
/// thread at a time.
class MapCounter {
 public:
  /// Counts a snapshot. Cost: one pass over the leaves of each changed volume, and one comparison
  /// per unchanged volume. `memory_bytes` excludes the memory of the writer,
  /// `Mapper::surface_bytes`.
  MapCounts Count(const MapSnapshot& snapshot);

 private:
  /// The cached counts of a volume. It owns the volume, so that no other volume can get the same
  /// address.
  struct CountedVolume {
    std::shared_ptr<const TsdfGrid> volume;
    std::size_t leaves = 0;
    std::size_t voxels = 0;
    std::size_t memory_bytes = 0;
  };

  static void Update(const std::shared_ptr<const TsdfGrid>& volume, CountedVolume* counted);

  std::map<Background::TileOrigin, CountedVolume> tiles_;
  std::map<ObjectId, CountedVolume> objects_;
};

/// Counts a single snapshot. Cost: one pass over all leaves, 7 ms for 1000 objects.
inline MapCounts CountMap(const MapSnapshot& snapshot) { return MapCounter().Count(snapshot); }

}  // namespace steadymap
