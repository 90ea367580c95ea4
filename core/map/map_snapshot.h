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

/// Names one leaf of a map: whose volume, and where in it.
struct LeafKey {
  ObjectId object;
  LeafOrigin origin;

  friend constexpr auto operator<=>(const LeafKey&, const LeafKey&) = default;
};

/// A map at one revision. Published as `shared_ptr<const MapSnapshot>`; any number of threads may
/// read one while the mapper goes on. Copying shares objects and volumes, and costs next to
/// nothing.
///
/// A revision is the sequence number of the newest log entry in it, so the same entries lead to the
/// same revision wherever commits or restarts fell. Nobody outside of the mapper and the store
/// relies on that: to them it is a number that rises.
struct MapSnapshot {
  /// An empty map.
  explicit MapSnapshot(const VoxelScale& voxel_scale = {})
      : scale(voxel_scale), free_space(kFreeCellVoxels * voxel_scale.voxel_size_m) {}

  /// Voxels of a side of a free-space cell.
  static constexpr double kFreeCellVoxels = 2.0;

  /// The newest log entry that is part of the map.
  MapSequence integrated() const { return MapSequence(revision.value()); }

  Revision revision;
  Timestamp last_capture_time;  ///< Of the newest frame; the epoch while there is none.
  VoxelScale scale;
  Background background;
  ObjectLibrary objects;   ///< Archived ones included.
  ObjectId newest_object;  ///< The last id given away; ids are never given twice.
  EventNumber last_event;  ///< Of the map's history; 0: nothing happened yet.
  /// Classes that the map's table has gained since it was created, in their order.
  std::vector<SemanticClass> added_classes;
  FreeSpace free_space;  ///< What cameras have looked through; empty where nobody keeps it.
  std::map<SensorName, RobotState>
      robots;  ///< By what takes the frames; for the mapper alone, too.
};

/// The leaf in the background or in an object; null where there is none.
LeafView FindLeaf(const MapSnapshot& map, const LeafKey& key);

}  // namespace steadymap
