#include "core/integration/seen_through_leaves.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/geometry/geometry.h"

namespace steadymap {
namespace {

/// The greatest depth in each square block of cells.
class MaxDepthGrid {
 public:
  explicit MaxDepthGrid(const SemanticCloud& cloud)
      : cells_wide_(cloud.cells_wide()),
        cells_high_(cloud.cells_high()),
        blocks_wide_((cells_wide_ + kSide - 1) / kSide),
        depth_m_(static_cast<std::size_t>(blocks_wide_) *
                     static_cast<std::size_t>((cells_high_ + kSide - 1) / kSide),
                 0.0F) {
    for (int row = 0; row < cells_high_; ++row) {
      for (int column = 0; column < cells_wide_; ++column) {
        float& block_m = depth_m_[BlockAt(column / kSide, row / kSide)];
        block_m = std::max(block_m, cloud.At(column, row).depth_m);
      }
    }
    for (const float depth_m : depth_m_) max_depth_m_ = std::max(max_depth_m_, depth_m);
  }

  float max_depth_m() const { return max_depth_m_; }

  /// Returns the greatest depth of the blocks within `radius` cells of a cell; 0 outside of the
  /// image.
  float MaxAround(const Eigen::Vector2d& cell, double radius) const {
    const int first_column = std::max(0, static_cast<int>(std::floor(cell.x() - radius)));
    const int last_column = std::min(cells_wide_ - 1, static_cast<int>(cell.x() + radius));
    const int first_row = std::max(0, static_cast<int>(std::floor(cell.y() - radius)));
    const int last_row = std::min(cells_high_ - 1, static_cast<int>(cell.y() + radius));
    if (first_column > last_column || first_row > last_row) return 0.0F;
    float max_m = 0.0F;
    for (int row = first_row / kSide; row <= last_row / kSide; ++row) {
      for (int column = first_column / kSide; column <= last_column / kSide; ++column) {
        max_m = std::max(max_m, depth_m_[BlockAt(column, row)]);
      }
    }
    return max_m;
  }

 private:
  static constexpr int kSide = 8;  ///< Cells per block.

  std::size_t BlockAt(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(blocks_wide_) +
           static_cast<std::size_t>(column);
  }

  int cells_wide_;
  int cells_high_;
  int blocks_wide_;
  std::vector<float> depth_m_;
  float max_depth_m_ = 0.0F;
};

/// True if an observed voxel lies on or behind a surface.
bool HasSurface(const LeafView& leaf) {
  bool has_surface = false;
  for (std::size_t i = 0; i < kLeafVoxels; ++i) {
    has_surface |= leaf.voxels[i].weight_units() > 0 && leaf.voxels[i].distance_steps() <= 0;
  }
  return has_surface;
}

/// Returns the box around the camera and the image at a depth.
Box BoxOfView(const SemanticCloud& cloud, double depth_m) {
  Box box(cloud.T_world_camera().translation());
  for (const int column : {0, cloud.cells_wide() - 1}) {
    for (const int row : {0, cloud.cells_high() - 1}) {
      box.extend(cloud.T_world_camera() * (depth_m * cloud.camera().Ray(column, row)));
    }
  }
  return box;
}

}  // namespace

std::vector<LeafOrigin> FindSeenThroughLeaves(const SemanticCloud& cloud,
                                              const Background& background,
                                              const VoxelScale& scale,
                                              double max_range_m) {
  std::vector<LeafOrigin> found;
  const MaxDepthGrid max_depth(cloud);
  const Eigen::Isometry3d T_camera_world = cloud.T_world_camera().inverse();
  // Half the diagonal of a leaf, whose centre lies half a voxel below the middle of its extent.
  const double radius_m = 0.5 * std::sqrt(3.0) * scale.leaf_size_m();
  const Eigen::Vector3d to_center = Eigen::Vector3d::Constant(0.5 * (kLeafSide - 1));
  const auto visit = [&](LeafOrigin origin, const LeafView& leaf) {
    const Eigen::Vector3d center_camera =
        T_camera_world *
        ((Eigen::Vector3d(origin.x, origin.y, origin.z) + to_center) * scale.voxel_size_m);
    const double z_m = center_camera.z();
    if (z_m - radius_m + scale.truncation_m > static_cast<double>(max_depth.max_depth_m())) return;
    if (z_m + radius_m < static_cast<double>(kNearM)) return;
    // A leaf around the camera may lie anywhere in the image.
    const double near_m = std::max(z_m - radius_m, static_cast<double>(kNearM));
    const double radius = std::max(cloud.camera().fx, cloud.camera().fy) * radius_m / near_m;
    const Eigen::Vector2d cell = cloud.camera().Project<double>(
        {center_camera.x(), center_camera.y(), std::max(z_m, near_m)});
    const double depth_m = static_cast<double>(max_depth.MaxAround(cell, radius + 1.0));
    if (z_m - radius_m + scale.truncation_m > depth_m) return;
    if (HasSurface(leaf)) found.push_back(origin);
  };
  const double range_m = std::min(max_range_m, static_cast<double>(max_depth.max_depth_m()));
  background.ForEachLeafNear(BoxOfView(cloud, range_m), scale, visit);
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace steadymap
