#include "core/association/cell_ownership.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace steadymap {
namespace {

// Cells that lie this far off a sample's plane belong to something else.
constexpr float kMaxOffPlaneM = 0.05F;

/// Which of the samples around a cell owns it, of those in whose plane it lies.
enum class OwnerChoice { kFirst, kNearest };

/// The owners of the cells of one frame.
class CellOwners {
 public:
  CellOwners(const SampleGrid& samples,
             const Association& association,
             OwnerChoice choice,
             const PinholeCamera& cell_camera)
      : samples_(samples),
        association_(association),
        choice_(choice),
        spacing_per_m_(static_cast<float>(SampleGrid::SpacingPerM(cell_camera))) {}

  std::uint32_t OwnerOf(int column, int row, const Eigen::Vector3f& position_world) const {
    const Corners corners = CornersOf(column, row);
    if (corners.is_empty()) return Association::kNone;
    // Which of them is nearest does not matter where all have one owner.
    const bool takes_first = choice_ == OwnerChoice::kFirst || HaveOneOwner(corners);
    std::uint32_t owner = Association::kNone;
    float least_off_plane_m = kMaxOffPlaneM;
    for (int v = corners.first_row; v <= corners.last_row; ++v) {
      for (int u = corners.first_column; u <= corners.last_column; ++u) {
        const SurfaceSample& sample = samples_.At(u, v);
        if (!sample.is_valid()) continue;
        const Eigen::Vector3f way = position_world - sample.position_world;
        const float off_plane_m = std::abs(way.dot(sample.normal_world));
        if (off_plane_m > least_off_plane_m) continue;
        if (choice_ == OwnerChoice::kNearest && way.norm() > ReachOf(sample)) continue;
        owner = association_.owner[samples_.Index(u, v)];
        if (takes_first) return owner;
        least_off_plane_m = off_plane_m;
      }
    }
    return owner;
  }

 private:
  /// The samples around a cell: one to four; none beyond the last of an odd number of cells.
  struct Corners {
    int first_column;
    int last_column;
    int first_row;
    int last_row;

    bool is_empty() const { return first_column > last_column || first_row > last_row; }
  };

  Corners CornersOf(int column, int row) const {
    const int u = column / SampleGrid::kStrideCells;
    const int v = row / SampleGrid::kStrideCells;
    return {u,
            std::min(u + column % SampleGrid::kStrideCells, samples_.width() - 1),
            v,
            std::min(v + row % SampleGrid::kStrideCells, samples_.height() - 1)};
  }

  bool HaveOneOwner(const Corners& corners) const {
    const std::uint32_t owner =
        association_.owner[samples_.Index(corners.first_column, corners.first_row)];
    for (int v = corners.first_row; v <= corners.last_row; ++v) {
      for (int u = corners.first_column; u <= corners.last_column; ++u) {
        if (association_.owner[samples_.Index(u, v)] != owner) return false;
      }
    }
    return true;
  }

  /// Returns how far a cell may be from a sample on one surface: behind a silhouette, the plane of
  /// the surface in front goes on.
  float ReachOf(const SurfaceSample& sample) const {
    return kMaxOffPlaneM + sample.area_m2 / (spacing_per_m_ * sample.depth_m);
  }

  const SampleGrid& samples_;
  const Association& association_;
  OwnerChoice choice_;
  float spacing_per_m_;  ///< Of samples, at a depth of one metre.
};

void GiveCells(const CellOwners& owners, SemanticCloud* cloud) {
  static_assert(SampleGrid::kStrideCells == 2, "between two samples lies one cell");
  const Eigen::Matrix3f rotation = cloud->T_world_camera().linear().cast<float>();
  const Eigen::Vector3f camera_world = cloud->T_world_camera().translation().cast<float>();
  std::vector<float> ray_x;
  ray_x.reserve(static_cast<std::size_t>(cloud->cells_wide()));
  for (int column = 0; column < cloud->cells_wide(); ++column) {
    ray_x.push_back(static_cast<float>(cloud->camera().Ray(column, 0).x()));
  }
  for (int row = 0; row < cloud->cells_high(); ++row) {
    const auto ray_y = static_cast<float>(cloud->camera().Ray(0, row).y());
    for (int column = 0; column < cloud->cells_wide(); ++column) {
      SurfaceCell& cell = cloud->MutableAt(column, row);
      if (!(cell.weight > 0.0F)) continue;
      const Eigen::Vector3f ray(ray_x[static_cast<std::size_t>(column)], ray_y, 1.0F);
      const std::uint32_t owner =
          owners.OwnerOf(column, row, camera_world + rotation * (ray * cell.depth_m));
      if (owner == Association::kNone) {
        cell.weight = 0.0F;
      } else {
        cell.owner = owner;
      }
    }
  }
}

}  // namespace

void GiveCellsToOwners(const SampleGrid& samples,
                       const Association& association,
                       SemanticCloud* cloud) {
  GiveCells(CellOwners(samples, association, OwnerChoice::kFirst, cloud->camera()), cloud);
}

void GiveCellsToNearestPlanes(const SampleGrid& samples,
                              const Association& association,
                              SemanticCloud* cloud) {
  GiveCells(CellOwners(samples, association, OwnerChoice::kNearest, cloud->camera()), cloud);
}

}  // namespace steadymap
