#pragma once

#include <cstddef>
#include <vector>

#include "core/frame/frame.h"
#include "core/map/map_snapshot.h"

namespace steadymap::benchmarks {

/// A short way to and fro in the middle of a large hall, and what a robot may know of that hall.
struct HallDrive {
  std::vector<Frame> frames;  ///< Without instances.
  MapSnapshot nearby;         ///< The 43 things that most of the pixels show.
  MapSnapshot whole;          ///< Every thing of the hall, some 5 000.
};

/// Renders the drive and makes the maps, in some seconds. Maps hold objects alone, each known from
/// all sides and long enough to count as settled. It takes 5 GB of memory.
HallDrive MakeHallDrive(const VoxelScale& scale);

}  // namespace steadymap::benchmarks
