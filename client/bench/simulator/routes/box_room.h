#pragma once

#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "client/bench/simulator/scene/route.h"
#include "core/map/object_event.h"

namespace steadymap {

/// A change of a box room between its drives.
enum class RoomChange {
  kNothing,
  kRemoved,        ///< While nobody looks.
  kRemovedInView,  ///< Between two frames of the first drive.
  kAdded,
  kMoved5Cm,
  kMoved10Cm,
  kMoved30Cm,
  kMoved1MOldFirst,  ///< The last drive looks at the old place first.
  kMoved1MNewFirst,
  kMoved5MOldFirst,
  kMoved5MNewFirst,
  kTurned15Deg,
  kTurned45Deg,
  kTurned90Deg,
  kSwappedShapes,   ///< Two things of one class and unlike shapes.
  kSwappedClasses,  ///< Two things of unlike classes and the same shape.
  kSwappedTwins,    ///< Two things of one class and the same shape: no change can be seen.
  kBackInPlace,     ///< Removed before the second drive, back before the third.
  kTouchingRemoved,
  kUpperRemoved,  ///< Of a stack of two.
  kLowerRemoved,  ///< Of a stack of two; the upper one then stands on the floor.
  kRemovedFromWall,
  kMugRemoved,  ///< From a table.
  kRackRemoved,
  kNeighbourAt3CmRemoved,  ///< Of two boxes of one class.
  kNeighbourAt8CmRemoved,
  kNeighbourAt15CmRemoved,
  kNeighbourAt30CmRemoved,
  kKnownRemovedInView,  ///< Between two frames of the second drive.
};

/// All changes, in their order.
std::vector<RoomChange> AllRoomChanges();

/// Returns the name of a change, such as `moved-5cm`.
std::string_view NameOf(RoomChange change);

/// The motion of the camera in the last drive; the other drives go around everything.
enum class RoomPath {
  kOrbit,  ///< Around the place of each thing that changes.
  kPass,   ///< Straight past it.
  kLook,   ///< Three frames from one place.
};

/// The setting of a box room.
struct BoxRoomSetting {
  RoomPath path = RoomPath::kOrbit;
  double frame_period_s = 0.2;
  bool stops = false;            ///< For 15 s half way on each drive, unless it is a look.
  double camera_height_m = 0.6;  ///< Above the floor.
  bool looks_down = false;       ///< By 45 degrees instead of level.
  double floor_world_m = 0.0;    ///< Height of the floor.
  double slope_rad = 0.0;        ///< Inclination of the floor, and of everything on it.
};

/// An event that a map of a box room must report.
struct RoomEvent {
  EventType type = EventType::kCreated;
  ClassId class_id;
  Eigen::AlignedBox3d box_world;  ///< Of the object after the event.
  bool is_furniture = false;      ///< Maybe seen in part only.
  /// False for furniture at the border of what the camera sees: a map may have it, but only once.
  bool is_required = true;
};

/// An object of the scene after the last drive.
struct RoomObject {
  ClassId class_id;
  Eigen::AlignedBox3d box_world;
  bool is_furniture = false;  ///< As for `RoomEvent`.
  bool is_required = true;
};

/// A room with a floor, a wall, a shelf, a table, and a few boxes, one of which changes. The truth
/// lists one event per change and one creation per object; a map may have the wall in any number of
/// pieces.
struct BoxRoom {
  Route route;
  std::vector<RoomEvent> events;  ///< In the order of the drives.
  std::vector<RoomObject> objects;
  ClassId wall_class;
  Eigen::AlignedBox3d wall_world;
};

BoxRoom MakeBoxRoom(RoomChange change, const BoxRoomSetting& setting);

}  // namespace steadymap
