#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/cuboid.h"
#include "core/map/object_evidence.h"
#include "core/map/stationarity.h"
#include "core/types/identifiers.h"
#include "core/types/timestamp.h"
#include "core/volume/tsdf_grid.h"

namespace steadymap {

/// Where an object stands: four degrees of freedom.
struct UprightPose {
  Eigen::Vector3d position_world = Eigen::Vector3d::Zero();  ///< Metres.
  double yaw_rad = 0.0;

  /// The pose as a transform.
  Eigen::Isometry3d ToIsometry() const {
    return Eigen::Translation3d(position_world) *
           Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  }

  friend bool operator==(const UprightPose&, const UprightPose&) = default;
};

/// What an object is to its map.
enum class ObjectStatus {
  kTentative,  ///< Seen too seldom to be believed; no part of the map yet.
  kPresent,    ///< Part of the map.
  kArchived,   ///< Gone from its place, kept for history and re-identification.
};

/// How often a class was seen on an object.
struct ClassVote {
  ClassId class_id;
  double weight = 0.0;  ///< Sum of the observations' weights.

  friend bool operator==(const ClassVote&, const ClassVote&) = default;
};

/// What is known of an object besides its volume, at one revision. The grid frame of the volume is
/// the object frame.
struct ObjectState {
  ObjectId id;
  ObjectStatus status = ObjectStatus::kTentative;
  Revision revision;             ///< Of the last frame that changed the object.
  ClassId class_id;              ///< The winner of the votes.
  std::vector<ClassVote> votes;  ///< By rising class, no class twice.
  UprightPose T_world_object;
  Cuboid cuboid;  ///< Around the surface, world frame.
  Belief belief;
  ObjectEvidence evidence;
  Timestamp first_seen;  ///< Capture time of the first frame that saw it.
  /// When it came to stand where it stands, later than `first_seen` if it was gone or elsewhere
  /// before; of an archived one, when it was found gone.
  Timestamp in_place_since;
  Timestamp last_seen;                     ///< Capture time of the last frame that agreed with it.
  std::uint64_t supporting_frames = 0;     ///< Frames that agreed with it.
  std::uint64_t contradicted_updates = 0;  ///< Times that the evidence spoke against it.

  friend bool operator==(const ObjectState&, const ObjectState&) = default;
};

/// A thing of the map, as far as one revision knows it.
struct MapObject : ObjectState {
  std::shared_ptr<const TsdfGrid> volume;  ///< Never null in a published object.
};

}  // namespace steadymap
