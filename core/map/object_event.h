#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "core/map/map_object.h"
#include "core/map/stationarity.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"

namespace steadymap {

/// The type of an event.
enum class EventType {
  kCreated,  ///< An object became part of the map.
  kUpdated,  ///< The background changed (policy `voxel_change`).
  kMoved,    ///< An object moved; `related`, created at the new place, is this object.
  /// An object was removed from its place, or a part of the object `related`, which no event has
  /// told to be an object of its own.
  kRemoved,
  kReturned,    ///< A removed object is back at its former place.
  kMerged,      ///< An object proved to be part of another object, `related`.
  kSplit,       ///< A part of the object `related` became an object.
  kRobotLost,   ///< A robot's frames disagree with the map; they are ignored.
  kRobotFound,  ///< A lost robot's frames agree with the map again.
  /// A sensor, `source`, finds the object gone time and again, while another one sees it. It stays.
  kContradicted,
};

/// The reason of an event.
enum class EventReason {
  kNewSurface,    ///< Surface was observed in space without known surface.
  kSeenThrough,   ///< Depth, or the labels of pixels without depth, show space behind it.
  kDisplaced,     ///< The surface was observed next to its mapped position.
  kReplaced,      ///< Newer surface in front of it leaves no room for it.
  kShapeMatched,  ///< Its shape was found at the new place.
  kConnected,     ///< Both objects are parts of one connected surface.
  kDisconnected,  ///< One part of the object is confirmed while another part is contradicted.
  kDisagreement,  ///< Most of a frame contradicts the map.
  kAgreement,     ///< The frames agree with the map again.
};

/// The pose of an object's frame before and after a move.
struct ObjectMove {
  UprightPose T_world_before;
  UprightPose T_world_after;

  friend bool operator==(const ObjectMove&, const ObjectMove&) = default;
};

/// An entry of a map's history. A consumer that adds the object of each `kCreated`, `kReturned`,
/// `kSplit` and `kMoved`, and then drops the object of each `kRemoved` and `kMerged`, if it has it,
/// and the `related` object of each `kMoved`, obtains the set of present objects.
struct ObjectEvent {
  EventType type = EventType::kCreated;
  EventReason reason = EventReason::kNewSurface;
  ObjectId object;  ///< 0 for events of robots and of the background.
  ClassId class_id;
  Timestamp time;     ///< Capture time of the deciding frame.
  Revision revision;  ///< Of the deciding frame: the first revision with the change.
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  ///< Of the cuboid, after the event.
  std::optional<Eigen::Vector3d> old_center_world;         ///< For `kMoved`, metres.
  std::optional<ObjectMove> move;                          ///< For moves found by shape.
  std::optional<double> confidence;                        ///< For `kMoved`, in [0, 1].
  Belief before;
  Belief after;
  std::uint64_t supporting_frames = 0;     ///< Number of frames that supported it.
  std::uint64_t contradicted_updates = 0;  ///< Number of belief updates with evidence against it.
  ObjectId related;                        ///< Of a move, merge, split or removed part; else 0.
  SensorName source;  ///< The sensor, for events of robots and `kContradicted`; else empty.

  /// True for an event of a robot.
  bool IsOfRobot() const { return object == kBackgroundId && !source.robot.empty(); }

  friend bool operator==(const ObjectEvent&, const ObjectEvent&) = default;
};

/// Returns the machine-readable name of a type: `created`, `moved`, ...
std::string_view NameOf(EventType type);

/// Returns the machine-readable name of a reason: `seen_through`, `replaced`, ...
std::string_view NameOf(EventReason reason);

}  // namespace steadymap
