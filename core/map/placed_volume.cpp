#include "core/map/placed_volume.h"

#include <cassert>

#include "core/geometry/cuboid.h"

namespace steadymap {
namespace {

/// Margin that keeps touching boxes in contact despite rounding errors, metres.
constexpr double kRoundingM = 1e-9;

}  // namespace

PlacedVolume BackgroundOf(const MapSnapshot& snapshot) { return {.voxels = &snapshot.background}; }

PlacedVolume VolumeOf(const MapObject& object) {
  return {object.volume.get(), &object, object.T_world_object.ToIsometry()};
}

std::vector<PlacedVolume> ShownVolumes(const MapSnapshot& snapshot) {
  std::vector<PlacedVolume> volumes = {BackgroundOf(snapshot)};
  for (const auto& [id, object] : snapshot.objects) {
    if (object->status == ObjectStatus::kPresent) volumes.push_back(VolumeOf(*object));
  }
  return volumes;
}

Box BoundsOf(const PlacedVolume& volume, double margin_m) {
  assert(volume.object != nullptr);
  const Cuboid& cuboid = volume.object->cuboid;
  Box bounds;
  for (const Eigen::Vector2d& corner : cuboid.BaseCorners()) {
    bounds.extend(Eigen::Vector3d(corner.x(), corner.y(), cuboid.lowest_m()));
    bounds.extend(Eigen::Vector3d(corner.x(), corner.y(), cuboid.highest_m()));
  }
  bounds.min().array() -= margin_m;
  bounds.max().array() += margin_m;
  return bounds;
}

bool LeafTouches(const PlacedVolume& volume,
                 LeafOrigin origin,
                 const VoxelScale& scale,
                 const Box& box_world) {
  const Eigen::Vector3d low = scale.voxel_size_m * Eigen::Vector3d(origin.x, origin.y, origin.z);
  const double side_m = scale.voxel_size_m * (kLeafSide - 1);
  if (volume.object == nullptr) {
    return box_world.intersects(Box(low, low + Eigen::Vector3d::Constant(side_m)));
  }
  const Cuboid leaf{volume.T_world_volume * (low + Eigen::Vector3d::Constant(0.5 * side_m)),
                    Eigen::Vector3d::Constant(side_m + 2.0 * kRoundingM),
                    volume.object->T_world_object.yaw_rad};
  const Cuboid box{box_world.center(), box_world.sizes(), 0.0};
  return DistanceBetween(leaf, box) == 0.0;
}

}  // namespace steadymap
