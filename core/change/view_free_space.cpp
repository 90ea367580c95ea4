#include "core/change/view_free_space.h"

#include <algorithm>

namespace steadymap {

ViewFreeSpace::ViewFreeSpace(const SemanticCloud& cloud,
                             const MinDepthGrid& tiles,
                             double max_depth_m)
    : cloud_(cloud),
      tiles_(tiles),
      columns_(cloud.cells_wide() / SampleGrid::kStrideCells),
      rows_(cloud.cells_high() / SampleGrid::kStrideCells),
      max_depth_m_(static_cast<float>(max_depth_m)),
      T_camera_world_(cloud.T_world_camera().inverse().cast<float>()),
      rotation_world_camera_(cloud.T_world_camera().linear().cast<float>()),
      camera_world_(cloud.T_world_camera().translation().cast<float>()) {}

ViewFreeSpace::Sight ViewFreeSpace::Look(const Eigen::Vector3f& point_world) const {
  Sight sight;
  sight.point_camera = T_camera_world_ * point_world;
  const float depth_m = sight.point_camera.z();
  if (!(depth_m > MinDepthGrid::kNearestLookM && depth_m < max_depth_m_)) return sight;
  // Tiles are counted from their corners, cells from their centres.
  const Eigen::Vector2f cell = cloud_.camera().Project(sight.point_camera);
  const float u = (cell.x() + 0.5F) / SampleGrid::kStrideCells;
  const float v = (cell.y() + 0.5F) / SampleGrid::kStrideCells;
  if (!(u >= 0.0F && v >= 0.0F && u < static_cast<float>(columns_) &&
        v < static_cast<float>(rows_))) {
    return sight;
  }
  sight.is_in_view = true;
  sight.column = static_cast<int>(u);
  sight.row = static_cast<int>(v);
  return sight;
}

bool ViewFreeSpace::LooksThrough(const Eigen::Vector3f& point_world, float margin_m) const {
  const Sight sight = Look(point_world);
  return sight.is_in_view &&
         tiles_.NearestAround(sight.column, sight.row) > sight.point_camera.z() + margin_m;
}

bool ViewFreeSpace::IsClear(const Eigen::Vector3f& point_world, float clearance_m) const {
  const Sight sight = Look(point_world);
  if (!sight.is_in_view) return false;
  const float ahead_m = tiles_.NearestAround(sight.column, sight.row) - sight.point_camera.z();
  if (!(ahead_m > clearance_m)) return false;
  // A ray may run for long close above a surface that it meets at a flat angle.
  const SurfaceCell& cell =
      cloud_.At(sight.column * SampleGrid::kStrideCells, sight.row * SampleGrid::kStrideCells);
  if (!(cell.weight > 0.0F)) return SampleGrid::kMinFacingCosine * ahead_m > clearance_m;
  const Eigen::Vector3f normal(cell.normal_x, cell.normal_y, cell.normal_z);
  return cell.offset_m - normal.dot(sight.point_camera) > clearance_m;
}

Eigen::Vector3f ViewFreeSpace::EndOfRay(int column, int row) const {
  const float depth_m = std::min(tiles_.NearestAround(column, row), max_depth_m_);
  // The ray through the centre of the tile.
  const Eigen::Vector3f ray_camera = cloud_.camera()
                                         .Ray((column + 0.5) * SampleGrid::kStrideCells - 0.5,
                                              (row + 0.5) * SampleGrid::kStrideCells - 0.5)
                                         .cast<float>();
  return camera_world_ + rotation_world_camera_ * (ray_camera * depth_m);
}

}  // namespace steadymap
