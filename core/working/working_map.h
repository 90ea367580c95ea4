#pragma once

#include <functional>
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
#include "core/working/object_edit.h"
#include "core/working/object_index.h"
#include "core/working/tracked_object.h"

namespace steadymap {

/// The result of a commit: a delta to store, and a snapshot to publish after the delta is stored.
struct MapCommit {
  MapDelta delta;
  std::shared_ptr<const MapSnapshot> snapshot;
};

/// A leaf of the volume of an object.
struct ObjectLeaf {
  TrackedObject* object = nullptr;
  LeafOrigin origin;
};

/// The map of the single writer: all state that outlives a frame, with the changes since the last
/// commit. A policy keeps all its state between frames here, so that a restart does not change the
/// result.
///
/// Every function marks its own changes. The state and the volume of an object change only by an
/// `ObjectEdit`, which marks the object. One thread at a time.
class WorkingMap {
 public:
  explicit WorkingMap(const MapConfig& config);

  /// Continues from a stored map. `snapshot.scale` must be the configuration's (asserted).
  void Restore(const MapSnapshot& snapshot);

  /// Starts the frame of `revision`. Subsequent changes have its capture time.
  void BeginFrame(Revision revision, Timestamp capture_time);

  /// Starts the end of a session, which has no frame: subsequent changes have the capture time of
  /// the last frame of the sensor; of an unknown one, of the last frame of the map.
  void BeginSessionEnd(Revision revision, const SensorName& sensor);

  /// Ends the frame: deletes the objects passed to `Delete` in it.
  void EndFrame();

  /// Advances to `revision`, with additional classes as the only change.
  void AddClasses(Revision revision, const std::vector<SemanticClass>& classes);

  /// Advances to `revision` without changes.
  void Advance(Revision revision) { map_.revision = revision; }

  /// Returns the classes added since the creation of the map.
  const std::vector<SemanticClass>& added_classes() const { return map_.added_classes; }

  /// Returns the revision of the current frame, or of the last one.
  Revision revision() const { return map_.revision; }

  /// Returns the capture time of the current frame, or that of the current end of a session.
  Timestamp now() const { return now_; }

  const VoxelScale& scale() const { return map_.scale; }

  const Background& background() const { return map_.background; }

  const FreeSpace& free_space() const { return map_.free_space; }

  /// Returns all objects by id, including archived ones. A reference to an object is valid until
  /// the object is deleted.
  const std::map<ObjectId, TrackedObject>& objects() const { return objects_; }

  /// Returns all objects, by increasing id. Cost: proportional to their number.
  std::vector<TrackedObject*> AllObjects();

  /// Returns the objects of any status whose surface bounds (aligned with the world's axes, metres)
  /// are within 1 mm of a box, by increasing id. The margin covers rounding differences. Cost:
  /// proportional to the objects around the box.
  std::vector<TrackedObject*> ObjectsNear(const Box& box_world);
  std::vector<const TrackedObject*> ObjectsNear(const Box& box_world) const;

  /// Returns the objects of status `kTentative`, by increasing id. Cost: proportional to their
  /// number.
  std::vector<TrackedObject*> TentativeObjects() { return FindAll(tentative_); }

  /// Returns the objects of status `kTentative` of the session of a source, and those that are of
  /// no source, by increasing id.
  std::vector<TrackedObject*> TentativeObjectsOf(const SensorName& source);
  std::vector<const TrackedObject*> TentativeObjectsOf(const SensorName& source) const;

  /// Returns the objects of status `kArchived`, including those passed to `Delete`, by increasing
  /// id. Cost: proportional to their number.
  std::vector<TrackedObject*> ArchivedObjects() { return FindAll(archived_); }

  /// Returns write access to an object of this map.
  [[nodiscard]] ObjectEdit Edit(TrackedObject* object);

  /// Adds an object with a new id, first and last seen now. The origin of its frame is the leaf
  /// corner nearest to `position_world`, so that its lattice is that of the world.
  TrackedObject& AddObject(const Eigen::Vector3d& position_world);

  /// Adds an object with the frame and state of `whole`, without evidence, gaps and voxels.
  TrackedObject& AddPart(const TrackedObject& whole);

  /// Archives the object, and deletes it at the end of the frame.
  void Delete(TrackedObject* object);

  /// Fuses the background's cells (owner 0) of the integrator's frame into the background.
  void FuseBackground(TsdfIntegrator* integrator);

  /// Replaces one leaf of the background. If `voxels` has no observed voxel, removes the leaf.
  void StoreBackgroundLeaf(LeafOrigin origin, const LeafVoxels& voxels);

  /// Fuses the cells of one owner in the integrator's frame into an object.
  void FuseObject(std::uint32_t owner, TrackedObject* object, TsdfIntegrator* integrator);

  /// Fuses the background's cells of the integrator's frame into objects that are tiles of the
  /// world, instead of into the background. `place_of` returns the leaf of an object for the origin
  /// of a leaf of the world, every time the same. Returns the changed objects, by increasing id.
  std::vector<TrackedObject*> FuseTiles(const std::function<ObjectLeaf(LeafOrigin)>& place_of,
                                        TsdfIntegrator* integrator);

  /// Returns the memory of the surfaces of all objects, bytes.
  std::size_t surface_bytes() const;

  /// Marks the segment between two points as free space, seen now by the session that started at
  /// `session_start`.
  void MarkFree(const Eigen::Vector3d& from_world,
                const Eigen::Vector3d& to_world,
                Timestamp session_start);

  /// Returns the state of a robot; null if there is none. Valid until the next `StoreRobot`.
  const RobotState* FindRobot(const SensorName& sensor) const;

  /// Stores the state of a robot. Beyond the maximum number of robots, removes the one of the
  /// others with the oldest last frame.
  void StoreRobot(const SensorName& sensor, const RobotState& state);

  /// Makes an event with the current state of an object. Complete it and pass it to `RecordEvent`.
  ObjectEvent MakeEvent(EventType type, EventReason reason, const TrackedObject& object) const;

  /// Makes an event of a robot.
  ObjectEvent MakeRobotEvent(EventType type, EventReason reason, const SensorName& sensor) const;

  void RecordEvent(const ObjectEvent& event) { events_.push_back(event); }

  /// Ends the work since the last commit. Without changes the delta is empty.
  MapCommit Commit();

 private:
  friend class ObjectEdit;

  /// Marks a change of the object's state or surface.
  void MarkChanged(TrackedObject* object);

  /// Marks changed leaves of the object.
  void MarkLeaves(const TrackedObject& object, std::span<const LeafOrigin> leaves);

  TrackedObject& Insert(const Eigen::Vector3d& position_world);
  void Register(const TrackedObject& object);
  std::vector<TrackedObject*> FindAll(const std::set<ObjectId>& ids);
  std::vector<ObjectId> IdsNear(const Box& box_world) const;
  bool IsRegistered() const;
  void CommitObjects(MapDelta* delta);
  void CommitLeaves(MapDelta* delta);
  void CommitFreeSpace(MapDelta* delta);
  void CommitRobots(MapDelta* delta);

  Timestamp now_;
  MapSnapshot map_;  ///< Newer than the last commit, except `objects`, which are as published.
  std::map<ObjectId, TrackedObject> objects_;
  ObjectIndex places_;            ///< Of all objects, as last marked.
  std::set<ObjectId> tentative_;  ///< Objects of status `kTentative`, as last marked.
  std::set<ObjectId> archived_;   ///< Objects of status `kArchived`, as last marked.
  Revision committed_;

  // Changes since the last commit.
  std::vector<LeafKey> changed_leaves_;     ///< With duplicates.
  std::set<ObjectId> changed_objects_;      ///< Including deleted objects.
  std::vector<LeafOrigin> changed_blocks_;  ///< Of free space, with duplicates.
  std::set<SensorName> changed_robots_;     ///< Including removed robots.
  std::vector<ObjectEvent> events_;
  std::vector<ObjectId> forgotten_;  ///< In the current frame.
};

}  // namespace steadymap
