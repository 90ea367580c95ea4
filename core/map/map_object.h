#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/cuboid.h"
#include "core/map/contradiction.h"
#include "core/map/object_evidence.h"
#include "core/map/seen_gap.h"
#include "core/map/stationarity.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"
#include "core/volume/tsdf_grid.h"

namespace steadymap {

/// A pose with four degrees of freedom: position and yaw.
struct UprightPose {
  Eigen::Vector3d position_world = Eigen::Vector3d::Zero();  ///< Metres.
  double yaw_rad = 0.0;

  /// Returns the pose as a transform from the object frame to the world frame.
  Eigen::Isometry3d ToIsometry() const {
    return Eigen::Translation3d(position_world) *
           Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  }

  friend bool operator==(const UprightPose&, const UprightPose&) = default;
};

/// The status of an object in its map.
enum class ObjectStatus {
  kTentative,  ///< Not enough frames support it yet; not part of the published map.
  kPresent,    ///< Part of the published map.
  kArchived,   ///< Removed from its place, kept for history and re-identification.
};

/// The weight of the observations of one class on an object.
struct ClassVote {
  ClassId class_id;
  double weight = 0.0;  ///< Sum of the weights of the observations.

  friend bool operator==(const ClassVote&, const ClassVote&) = default;
};

/// In how many frames an object of a session and an older one of it, which may be two parts of one
/// object, were connected, in how many they were apart, and in how many their outlines met in the
/// image, so that one may have occluded a connection.
struct PartVotes {
  ObjectId other;  ///< The older one.
  std::uint32_t connected = 0;
  std::uint32_t apart = 0;
  std::uint32_t occluded = 0;

  friend bool operator==(const PartVotes&, const PartVotes&) = default;
};

/// The state of an object at one revision, except its volume. The grid frame of the volume is the
/// object frame.
struct ObjectState {
  ObjectId id;
  ObjectStatus status = ObjectStatus::kTentative;
  Revision revision;             ///< Of the last frame that changed the object.
  ClassId class_id;              ///< The class with the most votes.
  std::vector<ClassVote> votes;  ///< By increasing class, without duplicates.
  /// True if the labels or instances of frames gave its extent; false if shape alone divided it
  /// from its surroundings. False for all objects that were stored before there was this field.
  bool has_given_extent = false;
  UprightPose T_world_object;
  Cuboid cuboid;  ///< Around the surface, world frame; of status `kTentative`, with yaw 0.
  Belief belief;
  ObjectEvidence evidence;
  std::vector<SessionLooks> looks;  ///< Of open sessions, by increasing source; not `kTentative`.
  Timestamp first_seen;             ///< Capture time of the first frame that observed it.
  /// Start of its presence at its current place; later than `first_seen` if it was removed or moved
  /// in between. For an archived object, the time of the last look, which found it gone.
  Timestamp in_place_since;
  Timestamp last_seen;                     ///< Capture time of the last frame that supports it.
  std::uint64_t supporting_frames = 0;     ///< Number of frames that support it.
  std::uint64_t contradicted_updates = 0;  ///< Number of belief updates with evidence against it.
  std::vector<PartVotes> parts;  ///< By increasing id, without duplicates; of status `kTentative`.
  std::vector<SeenGap> gaps;     ///< Beside it, by increasing cell; of status `kTentative`.
  /// Of status `kTentative`: whose session it is of; without a robot, of any. Else: which sensor
  /// saw it last.
  SensorName source;
  std::vector<Contradiction> contradictions;  ///< Of sensors about its presence.

  friend bool operator==(const ObjectState&, const ObjectState&) = default;
};

/// True if labels or instances gave the extent of an object. Labels do so only with a class.
inline bool HasGivenExtent(const ObjectState& state) {
  return state.has_given_extent || state.class_id != kNoClass;
}

/// True if an object is of the session of a source.
inline bool IsInSession(const ObjectState& state, const SensorName& source) {
  return state.status == ObjectStatus::kTentative &&
         (state.source.robot.empty() || state.source == source);
}

/// An object of a map at one revision.
struct MapObject : ObjectState {
  std::shared_ptr<const TsdfGrid> volume;  ///< Never null in a published object.
};

}  // namespace steadymap
