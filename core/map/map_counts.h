#pragma once

#include <cstddef>
#include <map>
#include <memory>

#include "core/map/map_snapshot.h"

namespace steadymap {

/// What a map holds, counted.
struct MapCounts {
  std::size_t present_objects = 0;
  std::size_t archived_objects = 0;
  std::size_t leaves = 0;  ///< Of background and present objects.
  std::size_t voxels = 0;  ///< Observed, of background and present objects.
  /// In memory: the volumes of background and objects, whatever their standing, what is kept of
  /// their surfaces, and the free space.
  std::size_t memory_bytes = 0;

  friend bool operator==(const MapCounts&, const MapCounts&) = default;
};

/// Counts what maps hold, remembering what has not changed since it counted last. One thread at a
/// time; for the revisions of one map.
class MapCounter {
 public:
  /// Cost: that of the volumes that changed, and a look at each of the others. The bytes leave out
  /// what the map's writer alone keeps: `Mapper::surface_bytes`.
  MapCounts Count(const MapSnapshot& snapshot);

 private:
  /// A volume as it was counted, kept so that no other takes its place in memory.
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

/// Counts one map once. Cost: a pass over all leaves, 7 ms for 1000 objects.
inline MapCounts CountMap(const MapSnapshot& snapshot) { return MapCounter().Count(snapshot); }

}  // namespace steadymap
