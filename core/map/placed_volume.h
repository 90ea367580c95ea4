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

/// A volume of a map with its pose. Valid as long as its snapshot.
struct PlacedVolume {
  const VoxelReader* voxels = nullptr;  ///< Never null.
  const MapObject* object = nullptr;    ///< The owner of the volume; null for the background.
  /// From the frame of the volume to the world frame; the identity for the background.
  Eigen::Isometry3d T_world_volume = Eigen::Isometry3d::Identity();

  ObjectId id() const { return object != nullptr ? object->id : kBackgroundId; }

  /// Returns the class of the object; 0 for the background.
  ClassId class_id() const { return object != nullptr ? object->class_id : ClassId(); }
};

/// Returns the volume of the background.
PlacedVolume BackgroundOf(const MapSnapshot& snapshot);

/// Returns the volume of an object at its current or last pose.
PlacedVolume VolumeOf(const MapObject& object);

/// Returns the published volumes of a map: the background, then its present objects by increasing
/// id.
std::vector<PlacedVolume> ShownVolumes(const MapSnapshot& snapshot);

/// Returns a world box that contains all surface of the volume's object: the bounds of its cuboid
/// plus `margin_m` (>= 0). The volume must belong to an object (asserted).
Box BoundsOf(const PlacedVolume& volume, double margin_m);

/// True if the box around the voxel centres of a leaf intersects `box_world`, borders included.
bool LeafTouches(const PlacedVolume& volume,
                 LeafOrigin origin,
                 const VoxelScale& scale,
                 const Box& box_world);

}  // namespace steadymap
