#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/map/map_object.h"
#include "core/map/object_surface.h"

namespace steadymap {

/// An object of the working map: its published state with cached values. Only an `ObjectEdit` can
/// change it, so that the map records every change.
class TrackedObject {
 public:
  /// Constructs a new object whose frame has its origin at `position_world`.
  TrackedObject(ObjectId id, const Eigen::Vector3d& position_world, const VoxelScale& scale);

  /// Continues from a published object and shares its volume.
  TrackedObject(const MapObject& published, const VoxelScale& scale);

  // No move and no assignment, which would change an object without an edit.
  TrackedObject(const TrackedObject&) = default;
  TrackedObject& operator=(const TrackedObject&) = delete;

  const ObjectState& state() const { return state_; }

  ObjectId id() const { return state_.id; }

  bool is_archived() const { return state_.status == ObjectStatus::kArchived; }

  /// True if it is deleted from the map at the end of the frame; until then it is archived.
  bool is_deleted() const { return is_deleted_; }

  /// True if it is archived and not to be deleted at the end of the frame.
  bool is_history() const { return is_archived() && !is_deleted_; }

  const TsdfGrid& volume() const { return *volume_; }

  const ObjectSurface& surface() const { return surface_; }

  /// Returns the surface points, world frame, metres.
  std::vector<Eigen::Vector3d> SurfaceInWorld() const;

  /// Returns the area of the surface, one voxel's face per surface point, square metres.
  double SurfaceAreaM2() const;

  /// Returns the bounds of the surface, object frame.
  const Box& bounds_object() const { return bounds_object_; }

  /// Returns the world-aligned box around `bounds_object()`; empty without surface.
  Box BoundsInWorld() const;

  /// Returns the cuboid around the surface but for a few voxels beside it, world frame. Cost: about
  /// 100 us after a change, else none.
  const Cuboid& cuboid() const;

  /// Returns the state for publication, which shares the volume.
  std::shared_ptr<const MapObject> Publish() const;

 private:
  friend class ObjectEdit;
  friend class WorkingMap;

  void MarkDeleted() {
    state_.status = ObjectStatus::kArchived;
    is_deleted_ = true;
  }

  /// Returns the volume for writing; cloned first if a published state shares it.
  TsdfGrid& MutableVolume();

  /// Replaces pose and volume by copies of those of another object.
  void TakeVolume(const TrackedObject& other);

  /// Updates surface and bounds after a change of some leaves of the volume.
  void UpdateSurface(std::span<const LeafOrigin> changed_leaves);

  void UpdateBounds();

  ObjectState state_;
  bool is_deleted_ = false;
  VoxelScale scale_;
  std::shared_ptr<TsdfGrid> volume_;
  ObjectSurface surface_;
  Box bounds_object_;
  mutable std::optional<Cuboid> cuboid_;  ///< None: not computed yet.
  mutable UprightPose cuboid_pose_;       ///< Pose of the object for `cuboid_`.
};

}  // namespace steadymap
