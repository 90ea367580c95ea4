#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/geometry.h"
#include "core/map_object.h"
#include "core/object_surface.h"

namespace steadymap {

/// An object in the hands of the mapper: its published state and what is kept beside it for speed.
class TrackedObject {
 public:
  /// A new object whose frame has its origin at `position_world`.
  TrackedObject(ObjectId id, const Eigen::Vector3d& position_world, const VoxelScale& scale);

  /// Goes on from a published object.
  TrackedObject(const MapObject& published, const VoxelScale& scale);

  ObjectState& state() { return state_; }

  const ObjectState& state() const { return state_; }

  ObjectId id() const { return state_.id; }

  bool is_archived() const { return state_.standing == ObjectStanding::kArchived; }

  const TsdfGrid& volume() const { return *volume_; }

  /// The volume for writing; cloned first if a published state shares it.
  TsdfGrid& MutableVolume();

  /// Takes pose and volume of another object instead of its own.
  void TakeVolume(const TrackedObject& other);

  const ObjectSurface& surface() const { return surface_; }

  /// Around the surface, object frame.
  const Box& bounds_object() const { return bounds_object_; }

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
  VoxelScale scale_;
  std::shared_ptr<TsdfGrid> volume_;
  ObjectSurface surface_;
  Box bounds_object_;
  mutable std::optional<Cuboid> cuboid_;  ///< None: to be computed.
  mutable UprightPose cuboid_pose_;       ///< Of the object when it was.
};

}  // namespace steadymap
