#pragma once

#include <map>
#include <vector>

#include "core/map/object_library.h"
#include "core/map/robot_state.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"
#include "core/volume/background.h"
#include "core/volume/free_space.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// The key of a leaf of a map: the owner of the volume, and the origin in that volume.
struct LeafKey {
  ObjectId object;
  LeafOrigin origin;

  friend constexpr auto operator<=>(const LeafKey&, const LeafKey&) = default;
};

/// A map at one revision. Published as `shared_ptr<const MapSnapshot>`; any number of threads may
/// read it while the mapper continues. A copy shares objects and volumes and is cheap.
///
/// A revision is the map sequence of the newest log entry in the map. Equal entries therefore give
/// equal revisions, independent of commits and restarts. Code outside of the mapper and the store
/// must not depend on this and treats a revision as an increasing number.
struct MapSnapshot {
  /// Constructs an empty map.
  explicit MapSnapshot(const VoxelScale& voxel_scale = {})
      : scale(voxel_scale), free_space(kFreeCellVoxels * voxel_scale.voxel_size_m) {}

  /// Side of a cell of free space, voxels.
  static constexpr double kFreeCellVoxels = 2.0;

  /// Returns the newest log entry in the map.
  MapSequence integrated() const { return MapSequence(revision.value()); }

  Revision revision;
  Timestamp last_capture_time;  ///< Of the newest frame; the epoch if there is none.
  VoxelScale scale;
  Background background;
  ObjectLibrary objects;   ///< Objects of every status.
  ObjectId newest_object;  ///< The last assigned id. Ids are never reused.
  EventNumber last_event;  ///< The newest event of the history; 0: none yet.
  /// Classes added to the class table since the creation of the map, in order of addition.
  std::vector<SemanticClass> added_classes;
  FreeSpace free_space;                     ///< Empty with policies that do not maintain it.
  std::map<SensorName, RobotState> robots;  ///< By sensor. Internal state of the mapper.
};

/// Returns a leaf of the background or of an object; null if it does not exist.
LeafView FindLeaf(const MapSnapshot& map, const LeafKey& key);

}  // namespace steadymap
