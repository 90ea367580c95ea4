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

/// An object in the hands of the mapper: its published state and what is kept beside it for speed.
class TrackedObject {
 public:
  /// A new object whose frame has its origin at `position_world`.
  TrackedObject(ObjectId id, const Eigen::Vector3d& position_world, const VoxelScale& scale);

  /// Goes on from a published object, whose volume it shares.
  TrackedObject(const MapObject& published, const VoxelScale& scale);

  ObjectState& state() { return state_; }

  const ObjectState& state() const { return state_; }

  ObjectId id() const { return state_.id; }

  bool is_archived() const { return state_.status == ObjectStatus::kArchived; }

  /// Whether it leaves the map for good when the frame ends; it is archived until then.
  bool is_forgotten() const { return is_forgotten_; }

  /// Whether it is history: archived, and to stay so.
  bool is_history() const { return is_archived() && !is_forgotten_; }

  void MarkForgotten() {
    state_.status = ObjectStatus::kArchived;
    is_forgotten_ = true;
  }

  const TsdfGrid& volume() const { return *volume_; }

  /// The volume for writing; cloned first if a published state shares it.
  TsdfGrid& MutableVolume();

  /// Takes pose and volume of another object instead of its own.
  void TakeVolume(const TrackedObject& other);

  const ObjectSurface& surface() const { return surface_; }

  /// The points of the surface, world frame, metres.
  std::vector<Eigen::Vector3d> SurfaceInWorld() const;

  /// Around the surface, object frame.
  const Box& bounds_object() const { return bounds_object_; }

  /// Around these bounds, along the axes of the world frame; empty without surface.
  Box BoundsInWorld() const;

  /// Brings surface and bounds up to date after leaves of the volume changed.
  void UpdateSurface(std::span<const LeafOrigin> changed_leaves);

  /// The same after the whole volume changed.
  void RebuildSurface();

  /// The upright box around the surface, world frame. Cost: some 100 us after a change, else none.
  const Cuboid& cuboid() const;

  /// The state for publication; shares the volume.
  std::shared_ptr<const MapObject> Publish() const;

 private:
  void UpdateBounds();

  ObjectState state_;
  bool is_forgotten_ = false;
  VoxelScale scale_;
  std::shared_ptr<TsdfGrid> volume_;
  ObjectSurface surface_;
  Box bounds_object_;
  mutable std::optional<Cuboid> cuboid_;  ///< None: to be computed.
  mutable UprightPose cuboid_pose_;       ///< Of the object when it was.
};

}  // namespace steadymap
