#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/integration/tsdf_integrator.h"
#include "core/map/map_delta.h"
#include "core/map/map_snapshot.h"
#include "core/map/object_event.h"
#include "core/types/identifiers.h"
#include "core/types/map_config.h"
#include "core/types/timestamp.h"
#include "core/volume/background.h"
#include "core/volume/free_space.h"
#include "core/working/object_index.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// What a commit makes of the frames since the one before: the delta to be stored, and the snapshot
/// to be published once it is.
struct MapCommit {
  MapDelta delta;
  std::shared_ptr<const MapSnapshot> snapshot;
};

/// A map in the hands of its one writer: all that outlives a frame, and what has changed of it
/// since the last commit. Whatever a policy wants to remember from frame to frame stands here, so
/// that a map goes on after a restart as if it had never stopped.
///
/// Whoever changes something says so with one of the `Mark` functions, and does so after the
/// change: what is not marked is not stored, nor found by place or standing. What integration
/// changes is marked by the `Fuse` functions themselves. One thread at a time.
class WorkingMap {
 public:
  explicit WorkingMap(const MapConfig& config);

  /// Continues from a stored map; `snapshot.scale` must be the configuration's (asserted).
  void Restore(const MapSnapshot& snapshot);

  /// Opens the frame that leads to `revision`; what follows happens at its capture time.
  void BeginFrame(Revision revision, Timestamp capture_time);

  /// Closes it: objects forgotten meanwhile are gone now.
  void EndFrame();

  /// Leads to `revision` with nothing but more classes.
  void AddClasses(Revision revision, const std::vector<SemanticClass>& classes);

  /// Leads to `revision` with nothing changed.
  void Advance(Revision revision) { map_.revision = revision; }

  /// Classes that were added since the map was created.
  const std::vector<SemanticClass>& added_classes() const { return map_.added_classes; }

  /// The frame at hand, or the last one.
  Revision revision() const { return map_.revision; }

  Timestamp now() const { return map_.last_capture_time; }

  const VoxelScale& scale() const { return map_.scale; }

  const Background& background() const { return map_.background; }

  const FreeSpace& free_space() const { return map_.free_space; }

  /// All objects by id, archived ones included. Valid until they are forgotten.
  const std::map<ObjectId, TrackedObject>& objects() const { return objects_; }

  std::map<ObjectId, TrackedObject>& mutable_objects() { return objects_; }

  /// The objects of any standing whose surface bounds (upright box along the world's axes, metres)
  /// come within a millimetre of a box, by rising id: all that could be found there, though
  /// rounding differs. Cost: that of the objects around the box, not of the map.
  std::vector<TrackedObject*> ObjectsNear(const Box& box_world);
  std::vector<const TrackedObject*> ObjectsNear(const Box& box_world) const;

  /// Those with the standing `kTentative`, by rising id. Cost: theirs.
  std::vector<TrackedObject*> TentativeObjects() { return FindAll(tentative_); }

  /// Those with the standing `kArchived`, being forgotten or not, by rising id. Cost: theirs.
  std::vector<TrackedObject*> ArchivedObjects() { return FindAll(archived_); }

  /// A new object of a new id, first and last seen now, whose frame has its origin at the corner of
  /// voxels nearest to `position_world`, so that its voxels are voxels of the world.
  TrackedObject& AddObject(const Eigen::Vector3d& position_world);

  /// A new object in the frame and with the state of `whole`, without its evidence and voxels.
  TrackedObject& AddPart(const TrackedObject& whole);

  /// Archives the object, and takes it out of the map for good when the frame ends.
  void Forget(TrackedObject* object);

  /// Puts `object` with the volume of `other` into the place of `other`, which keeps its own.
  void TakeVolume(TrackedObject* object, const TrackedObject& other);

  /// The state of the object has changed, or its surface.
  void MarkChanged(TrackedObject* object);

  /// Voxels of the object have changed, and with them its state.
  void MarkLeaves(TrackedObject* object, std::span<const LeafOrigin> leaves);

  /// Fuses the cells of the integrator's frame that belong to the background (owner 0) into it.
  void FuseBackground(TsdfIntegrator* integrator);

  /// Replaces one leaf of the background; one without observed voxels removes it.
  void StoreBackgroundLeaf(LeafOrigin origin, const LeafVoxels& voxels);

  /// Fuses those of one owner into an object.
  void FuseObject(std::uint32_t owner, TrackedObject* object, TsdfIntegrator* integrator);

  /// Bytes of the surfaces of all objects.
  std::size_t surface_bytes() const;

  /// Marks what lies between two points as looked through.
  void MarkFree(const Eigen::Vector3d& from_world, const Eigen::Vector3d& to_world);

  /// What is remembered of a robot; null if nothing is. Valid until one is stored.
  const RobotState* FindRobot(const SensorName& sensor) const;

  /// Remembers a robot, and forgets the one seen longest ago where that makes too many.
  void StoreRobot(const SensorName& sensor, const RobotState& state);

  /// An event about an object as it stands now; add what it lacks and `RecordEvent` it.
  ObjectEvent MakeEvent(EventType type, EventReason reason, const TrackedObject& object) const;

  /// An event about a robot.
  ObjectEvent MakeRobotEvent(EventType type, EventReason reason, const SensorName& sensor) const;

  void RecordEvent(const ObjectEvent& event) { events_.push_back(event); }

  /// Closes the work since the last commit. With nothing since then: an empty delta.
  MapCommit Commit();

 private:
  TrackedObject& Insert(const Eigen::Vector3d& position_world);
  void Register(const TrackedObject& object);
  std::vector<TrackedObject*> FindAll(const std::set<ObjectId>& ids);
  std::vector<ObjectId> IdsNear(const Box& box_world) const;
  bool IsRegistered() const;
  void CommitObjects(MapDelta* delta);
  void CommitLeaves(MapDelta* delta);
  void CommitFreeSpace(MapDelta* delta);
  void CommitRobots(MapDelta* delta);

  MapSnapshot map_;  ///< Ahead of the last commit but for `objects`, which are as published.
  std::map<ObjectId, TrackedObject> objects_;
  ObjectIndex places_;            ///< Of all objects, as last marked.
  std::set<ObjectId> tentative_;  ///< Those of this standing, as last marked.
  std::set<ObjectId> archived_;   ///< Likewise.
  Revision committed_;

  // Since the last commit.
  std::vector<LeafKey> changed_leaves_;     ///< With repetitions.
  std::set<ObjectId> changed_objects_;      ///< Forgotten ones included.
  std::vector<LeafOrigin> changed_blocks_;  ///< Of free space; with repetitions.
  std::set<SensorName> changed_robots_;     ///< Forgotten ones included.
  std::vector<ObjectEvent> events_;
  std::vector<ObjectId> forgotten_;  ///< In the frame at hand.
};

}  // namespace steadymap
