#include "core/association/cell_ownership.h"

#include <array>
#include <cmath>

namespace steadymap {
namespace {

// Cells that lie this far off a sample's plane belong to something else.
constexpr float kMaxOffPlaneM = 0.05F;

/// Owner of the nearest sample whose plane holds the cell.
std::uint32_t OwnerOf(int column,
                      int row,
                      const Eigen::Vector3f& position_world,
                      const SampleGrid& samples,
                      const Association& association,
                      float spacing_per_m,
                      bool takes_nearest) {
  std::uint32_t owner = Association::kNone;
  float nearest_m = kMaxOffPlaneM;
  // A cell between samples has up to four around it.
  constexpr std::array<std::array<int, 2>, 4> kCorners = {{{0, 0}, {1, 0}, {0, 1}, {1, 1}}};
  for (const auto& [right, down] : kCorners) {
    const int u = column / SampleGrid::kStrideCells + right * (column % SampleGrid::kStrideCells);
    const int v = row / SampleGrid::kStrideCells + down * (row % SampleGrid::kStrideCells);
    if (u >= samples.width() || v >= samples.height()) continue;
    const SurfaceSample& sample = samples.At(u, v);
    if (!sample.is_valid()) continue;
    const float off_plane_m = (position_world - sample.position_world).dot(sample.normal_world);
    if (std::abs(off_plane_m) > nearest_m) continue;
    if (takes_nearest) {
      // Behind a silhouette, the plane of the surface in front goes on.
      const float spacing_m = spacing_per_m * sample.depth_m;
      const float reach_m = kMaxOffPlaneM + sample.area_m2 / spacing_m;
      if ((position_world - sample.position_world).squaredNorm() > reach_m * reach_m) continue;
    }
    owner = association.owner[samples.Index(u, v)];
    if (!takes_nearest) return owner;
    nearest_m = std::abs(off_plane_m);
  }
  return owner;
}

void GiveCells(const SampleGrid& samples,
               const Association& association,
               bool takes_nearest,
               SemanticCloud* cloud) {
  static_assert(SampleGrid::kStrideCells == 2, "between two samples lies one cell");
  const Eigen::Matrix3f rotation = cloud->T_world_camera().linear().cast<float>();
  const Eigen::Vector3f camera_world = cloud->T_world_camera().translation().cast<float>();
  const auto spacing_per_m = static_cast<float>(SampleGrid::kStrideCells /
                                                std::sqrt(cloud->camera().fx * cloud->camera().fy));
  for (int row = 0; row < cloud->cells_high(); ++row) {
    for (int column = 0; column < cloud->cells_wide(); ++column) {
      SurfaceCell& cell = cloud->MutableAt(column, row);
      if (!(cell.weight > 0.0F)) continue;
      const Eigen::Vector3f ray = cloud->camera().Ray(column, row).cast<float>();
      const std::uint32_t owner = OwnerOf(column,
                                          row,
                                          camera_world + rotation * (ray * cell.depth_m),
                                          samples,
                                          association,
                                          spacing_per_m,
                                          takes_nearest);
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
  GiveCells(samples, association, false, cloud);
}

void GiveCellsToNearestPlanes(const SampleGrid& samples,
                              const Association& association,
                              SemanticCloud* cloud) {
  GiveCells(samples, association, true, cloud);
}

}  // namespace steadymap
