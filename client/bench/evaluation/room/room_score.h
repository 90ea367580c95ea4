#pragma once

#include <string>
#include <vector>

#include "client/bench/simulator/routes/box_room.h"
#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"

namespace steadymap {

/// Limits of the comparison of a map with the truth of a box room.
struct RoomTolerance {
  double place_m = 0.15;         ///< Of the centre of an event or object.
  double cuboid_m = 0.055;       ///< Of the centre and of each side of a thing's cuboid.
  bool compares_classes = true;  ///< False for frames without labels.
};

/// The result of one case.
struct RoomScore {
  std::vector<std::string> event_faults;   ///< Events that are missing or too many.
  std::vector<std::string> object_faults;  ///< Present objects that are missing or too many.
  std::vector<std::string> cuboid_faults;  ///< Of objects beyond the tolerance.
  double worst_cuboid_m = 0.0;  ///< Largest error of a side or of the centre of a thing's cuboid.

  /// True if the map reports just the true events and has just the true objects.
  bool is_exact() const { return event_faults.empty() && object_faults.empty(); }
};

/// Returns the largest error of a face of the box around a cuboid, metres.
double CuboidErrorM(const Cuboid& cuboid, const Eigen::AlignedBox3d& truth_world);

/// Compares strictly: each true event and object needs one of the map, and the map may have no
/// others. Events of robots count as too many.
RoomScore ScoreRoom(const BoxRoom& room,
                    const std::vector<ObjectEvent>& events,
                    const MapSnapshot& map,
                    const RoomTolerance& tolerance);

}  // namespace steadymap
