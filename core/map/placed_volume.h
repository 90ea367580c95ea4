#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/geometry.h"
#include "core/map/map_object.h"
#include "core/map/map_snapshot.h"
#include "core/types/identifiers.h"
#include "core/volume/tsdf_grid.h"
#include "core/volume/voxel_leaf.h"

namespace steadymap {

/// One volume of a map and where it stands. Valid as long as the snapshot it is of.
struct PlacedVolume {
  const VoxelReader* voxels = nullptr;  ///< Never null.
  const MapObject* object = nullptr;    ///< Whose volume it is; null for the background.
  /// Takes the volume's frame to the world; the identity for the background.
  Eigen::Isometry3d T_world_volume = Eigen::Isometry3d::Identity();

  ObjectId id() const { return object != nullptr ? object->id : kBackgroundId; }

  /// 0 for the background.
  ClassId class_id() const { return object != nullptr ? object->class_id : ClassId(); }
};

/// The volume of what belongs to no object.
PlacedVolume BackgroundOf(const MapSnapshot& snapshot);

/// The volume of an object, where it stands or stood last.
PlacedVolume VolumeOf(const MapObject& object);

/// What a map shows: its background, then its present objects by rising id.
std::vector<PlacedVolume> ShownVolumes(const MapSnapshot& snapshot);

/// A world box that holds all surface of the volume's object, `margin_m` (>= 0) wider than its
/// cuboid. The volume must be an object's (asserted).
Box BoundsOf(const PlacedVolume& volume, double margin_m);

/// Whether the box around the voxel centres of a leaf, where it stands in the world, reaches into
/// `box_world`; borders count.
bool LeafTouches(const PlacedVolume& volume,
                 LeafOrigin origin,
                 const VoxelScale& scale,
                 const Box& box_world);

}  // namespace steadymap
