#include "core/change/view_free_space.h"

#include <algorithm>

#include "core/change/visibility.h"

namespace steadymap {
namespace {

// A surface of unknown slant is met at 11 degrees at the flattest: a fifth.
constexpr float kFlattestSlant = 5.0F;

}  // namespace

ViewFreeSpace::ViewFreeSpace(const SemanticCloud& cloud,
                             const MinDepthGrid& tiles,
                             double max_depth_m)
    : cloud_(cloud),
      tiles_(tiles),
      columns_(cloud.cells_wide() / SampleGrid::kStrideCells),
      rows_(cloud.cells_high() / SampleGrid::kStrideCells),
      max_depth_m_(static_cast<float>(max_depth_m)),
      focal_x_(static_cast<float>(cloud.camera().fx / SampleGrid::kStrideCells)),
      focal_y_(static_cast<float>(cloud.camera().fy / SampleGrid::kStrideCells)),
      // Places are counted from a tile's corner, cells from their middle.
      center_x_(static_cast<float>((cloud.camera().cx + 0.5) / SampleGrid::kStrideCells)),
      center_y_(static_cast<float>((cloud.camera().cy + 0.5) / SampleGrid::kStrideCells)),
      T_camera_world_(cloud.T_world_camera().inverse().cast<float>()),
      rotation_world_camera_(cloud.T_world_camera().linear().cast<float>()),
      camera_world_(cloud.T_world_camera().translation().cast<float>()) {}

ViewFreeSpace::Sight ViewFreeSpace::Look(const Eigen::Vector3f& point_world) const {
  Sight sight;
  sight.point_camera = T_camera_world_ * point_world;
  const float depth_m = sight.point_camera.z();
  if (!(depth_m > kMinJudgedDepthM && depth_m < max_depth_m_)) return sight;
  const float u = focal_x_ * sight.point_camera.x() / depth_m + center_x_;
  const float v = focal_y_ * sight.point_camera.y() / depth_m + center_y_;
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
  if (!(cell.weight > 0.0F)) return ahead_m > kFlattestSlant * clearance_m;
  const Eigen::Vector3f normal(cell.normal_x, cell.normal_y, cell.normal_z);
  return cell.offset_m - normal.dot(sight.point_camera) > clearance_m;
}

Eigen::Vector3f ViewFreeSpace::EndOfRay(int column, int row) const {
  const float depth_m = std::min(tiles_.NearestAround(column, row), max_depth_m_);
  const Eigen::Vector3f ray_camera((static_cast<float>(column) + 0.5F - center_x_) / focal_x_,
                                   (static_cast<float>(row) + 0.5F - center_y_) / focal_y_,
                                   1.0F);
  return camera_world_ + rotation_world_camera_ * (ray_camera * depth_m);
}

}  // namespace steadymap
