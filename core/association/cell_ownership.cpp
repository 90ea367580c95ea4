#include "core/association/cell_ownership.h"

#include <array>
#include <cmath>

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
    // A cell between samples has up to four around it.
    constexpr std::array<std::array<int, 2>, 4> kCorners = {{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};
    std::uint32_t owner = Association::kNone;
    float least_off_plane_m = kMaxOffPlaneM;
    for (const auto& [right, down] : kCorners) {
      const int u = column / SampleGrid::kStrideCells + right * (column % SampleGrid::kStrideCells);
      const int v = row / SampleGrid::kStrideCells + down * (row % SampleGrid::kStrideCells);
      if (u >= samples_.width() || v >= samples_.height()) continue;
      const SurfaceSample& sample = samples_.At(u, v);
      if (!sample.is_valid()) continue;
      const Eigen::Vector3f way = position_world - sample.position_world;
      const float off_plane_m = std::abs(way.dot(sample.normal_world));
      if (off_plane_m > least_off_plane_m) continue;
      if (choice_ == OwnerChoice::kNearest && way.norm() > ReachOf(sample)) continue;
      owner = association_.owner[samples_.Index(u, v)];
      if (choice_ == OwnerChoice::kFirst) return owner;
      least_off_plane_m = off_plane_m;
    }
    return owner;
  }

 private:
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
  for (int row = 0; row < cloud->cells_high(); ++row) {
    for (int column = 0; column < cloud->cells_wide(); ++column) {
      SurfaceCell& cell = cloud->MutableAt(column, row);
      if (!(cell.weight > 0.0F)) continue;
      const Eigen::Vector3f ray = cloud->camera().Ray(column, row).cast<float>();
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
