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

/// What happened to an object.
enum class EventType {
  kCreated,     ///< Became part of the map.
  kUpdated,     ///< Its class or extent changed much.
  kMoved,       ///< Stands elsewhere now; what was created there, `related`, was this.
  kRemoved,     ///< No longer stands where it stood.
  kReturned,    ///< Stands again where it stood before it was removed.
  kMerged,      ///< Turned out to be part of another object, `related`.
  kSplit,       ///< Became an object of its own; was part of `related` so far.
  kRobotLost,   ///< A robot's frames disagree with the whole map; they are not used.
  kRobotFound,  ///< They agree again.
};

/// Why the map decided so.
enum class EventReason {
  kNewSurface,    ///< Surface was seen where nothing was known.
  kSeenThrough,   ///< Depth, or labels of what is out of reach, tell of what is behind it.
  kDisplaced,     ///< The surface was found next to where it should be.
  kReplaced,      ///< Something newer stands in front of it, closer than anything fits between.
  kShapeMatched,  ///< Its shape was found at the new place.
  kConnected,     ///< Both are parts of one surface.
  kDisconnected,  ///< A part agrees while another one is contradicted.
  kDisagreement,  ///< Most of a frame contradicts the map.
  kAgreement,     ///< Frames fit the map again.
};

/// How an object moved: where its frame stood, and where the same frame stands now.
struct ObjectMove {
  UprightPose T_world_before;
  UprightPose T_world_after;

  friend bool operator==(const ObjectMove&, const ObjectMove&) = default;
};

/// One entry of a map's history. Who adds each object that is created, returns or is split off, and
/// drops each that is removed or merged and the `related` one of each move, has those that are part
/// of the map.
struct ObjectEvent {
  EventType type = EventType::kCreated;
  EventReason reason = EventReason::kNewSurface;
  ObjectId object;  ///< 0 for events of robots.
  ClassId class_id;
  Timestamp time;     ///< Capture time of the frame that decided.
  Revision revision;  ///< Of that frame: the first revision that shows it.
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();  ///< Of its cuboid, after the event.
  std::optional<Eigen::Vector3d> old_center_world;         ///< For moves.
  std::optional<ObjectMove> move;                          ///< For moves told by the shape.
  std::optional<double> confidence;                        ///< For moves, in [0, 1].
  Belief before;
  Belief after;
  std::uint64_t supporting_frames = 0;     ///< Frames that had agreed with it.
  std::uint64_t contradicted_updates = 0;  ///< Times that the evidence had spoken against it.
  ObjectId related;                        ///< The other object of a move, merge or split; else 0.
  SensorName source;  ///< For events of robots: whom they are about; else empty.

  /// Whether it is about a robot, not about an object.
  bool IsOfRobot() const { return !source.robot.empty(); }

  friend bool operator==(const ObjectEvent&, const ObjectEvent&) = default;
};

/// `created`, `moved`, ...: how a type is written for programs.
std::string_view NameOf(EventType type);

/// `seen_through`, `replaced`, ...
std::string_view NameOf(EventReason reason);

}  // namespace steadymap
