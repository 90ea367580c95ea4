#pragma once

#include <map>
#include <memory>

#include "core/background.h"
#include "core/identifiers.h"
#include "core/map_object.h"
#include "core/timestamp.h"
#include "core/voxel_leaf.h"

namespace steadymap {

/// A map at one revision. Published as `shared_ptr<const MapSnapshot>`; any number of threads may
/// read one while the mapper goes on. Copying shares the volumes.
///
/// A revision is the sequence number of the newest frame in it, so the same frames lead to the same
/// revision wherever commits or restarts fell.
struct MapSnapshot {
  Revision revision;
  Timestamp last_capture_time;  ///< Of the newest frame; the epoch while there is none.
  VoxelScale scale;
  Background background;
  std::map<ObjectId, std::shared_ptr<const MapObject>> objects;  ///< Archived ones included.
};

}  // namespace steadymap
