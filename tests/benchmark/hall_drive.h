#pragma once

#include <cstddef>
#include <vector>

#include "core/frame/frame.h"
#include "core/map/map_snapshot.h"

namespace steadymap::benchmarks {

/// A short drive back and forth in the middle of a large hall, and two maps of that hall.
struct HallDrive {
  std::vector<Frame> frames;  ///< Without instances.
  MapSnapshot nearby;         ///< The 43 objects with the most pixels.
  MapSnapshot whole;          ///< All objects of the hall, about 5 000.
};

/// Renders the drive and builds the maps, in some seconds. The maps contain only objects, each
/// observed from all sides and confirmed. Needs 5 GB of memory.
HallDrive MakeHallDrive(const VoxelScale& scale);

}  // namespace steadymap::benchmarks
