#pragma once

#include <memory>

#include "core/map/map_snapshot.h"
#include "tests/support/analytic_solid.h"

namespace steadymap::testing {

/// Returns the volume of a floor: the plane z = 0 between -2 and 2 m, observed up to the truncation
/// distance on both sides.
inline TsdfGrid FloorVolume(const VoxelScale& scale) {
  const Box bounds(Eigen::Vector3d(-2.0, -2.0, -scale.truncation_m),
                   Eigen::Vector3d(2.0, 2.0, scale.truncation_m));
  return MakeVolume([](const Eigen::Vector3d& point) { return point.z(); },
                    bounds,
                    scale,
                    [&](const Eigen::Vector3d& point) { return bounds.contains(point); });
}

/// Returns the volume of a wall of 1 m2 that faces the origin at `depth_m` along x, observed up to
/// the truncation distance on both sides.
inline TsdfGrid WallVolume(double depth_m, const VoxelScale& scale = {}) {
  const Box bounds(Eigen::Vector3d(depth_m - scale.truncation_m, -0.5, -0.5),
                   Eigen::Vector3d(depth_m + scale.truncation_m, 0.5, 0.5));
  return MakeVolume([depth_m](const Eigen::Vector3d& point) { return depth_m - point.x(); },
                    bounds,
                    scale,
                    [&](const Eigen::Vector3d& point) { return bounds.contains(point); });
}

/// Returns a map of the floor without objects.
inline MapSnapshot FloorMap(const VoxelScale& scale = {}) {
  MapSnapshot map(scale);
  map.revision = Revision(7);
  const TsdfGrid floor = FloorVolume(scale);
  floor.ForEachLeaf([&](LeafOrigin origin, const LeafView&) {
    LeafVoxels voxels;
    floor.LoadLeaf(origin, &voxels);
    map.background.MutableTile(origin).StoreLeaf(origin, voxels);
  });
  return map;
}

/// Returns a box-shaped object of `size_m` with its volume centred at its frame's origin.
inline MapObject BoxObject(ObjectId id,
                           const Eigen::Vector3d& size_m,
                           const UprightPose& T_world_object,
                           const VoxelScale& scale = {}) {
  const Box body(-0.5 * size_m, 0.5 * size_m);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(scale.truncation_m);
  MapObject object;
  object.id = id;
  object.status = ObjectStatus::kPresent;
  object.class_id = ClassId(static_cast<std::uint16_t>(100 + id.value()));
  object.T_world_object = T_world_object;
  object.cuboid = {T_world_object.position_world, size_m, T_world_object.yaw_rad};
  object.volume = std::make_shared<const TsdfGrid>(
      MakeVolume([body](const Eigen::Vector3d& point) { return DistanceFrom({body}, point); },
                 Box(body.min() - reach, body.max() + reach),
                 scale,
                 [](const Eigen::Vector3d&) { return true; }));
  return object;
}

inline void AddObject(const MapObject& object, MapSnapshot* map) {
  map->objects.insert_or_assign(object.id, std::make_shared<const MapObject>(object));
}

/// The box of `BoxOverFloor`: its size, and its rotated frame in the world.
inline const Eigen::Vector3d kBoxSizeM(0.6, 0.4, 0.5);
inline constexpr double kBoxYawRad = 0.4;
inline const UprightPose kBoxPlace{{0.5, -0.3, 0.6}, kBoxYawRad};

/// Returns a map with a box (object 3) above the floor, outside the floor's truncation band, with
/// stationarity 0.75.
inline MapSnapshot BoxOverFloor() {
  MapSnapshot map = FloorMap();
  MapObject box = BoxObject(ObjectId(3), kBoxSizeM, kBoxPlace);
  box.belief.alpha = 3.0;
  AddObject(box, &map);
  return map;
}

}  // namespace steadymap::testing
