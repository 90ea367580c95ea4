#include "core/association/sample_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace steadymap {
namespace {

// Neighbours further apart belong to different surfaces. Grows with depth as the grid's spacing and
// the sensor's noise do.
constexpr float kMaxGapM = 0.08F;
constexpr float kMaxGapPerMetre = 0.04F;

/// The commonest class among a cell and its neighbours at the same depth: a border that is off by a
/// pixel moves nothing, and a thin thing keeps its class.
std::uint16_t MajorityLabel(const SemanticCloud& cloud, int column, int row) {
  const float depth_m = cloud.At(column, row).depth_m;
  // One surface that is seen at the flattest angle, and the noise of both depths.
  const auto spacing_m = static_cast<float>(SampleGrid::SpacingPerM(cloud.camera())) * depth_m;
  const auto noise_m = static_cast<float>(M_SQRT2 * cloud.CellSigmaM(static_cast<double>(depth_m)));
  const float max_gap_m = spacing_m / SampleGrid::kMinFacingCosine + kSigmas * noise_m;
  std::array<std::uint16_t, 9> labels;
  std::size_t count = 0;
  for (int v = std::max(row - 2, 0); v <= std::min(row + 2, cloud.cells_high() - 1); v += 2) {
    for (int u = std::max(column - 2, 0); u <= std::min(column + 2, cloud.cells_wide() - 1);
         u += 2) {
      if (std::abs(cloud.At(u, v).depth_m - depth_m) > max_gap_m) continue;
      labels[count++] = cloud.LabelAt(u, v);
    }
  }
  const std::uint16_t own = cloud.LabelAt(column, row);
  std::uint16_t winner = own;
  std::ptrdiff_t most = std::count(labels.begin(), labels.begin() + count, own);
  if (most > static_cast<std::ptrdiff_t>(count / 2)) return own;
  for (std::size_t i = 0; i < count; ++i) {
    const std::ptrdiff_t votes = std::count(labels.begin(), labels.begin() + count, labels[i]);
    if (votes > most) {
      most = votes;
      winner = labels[i];
    }
  }
  return winner;
}

}  // namespace

void SampleGrid::Compute(const SemanticCloud& cloud) {
  width_ = cloud.cells_wide() / kStrideCells;
  height_ = cloud.cells_high() / kStrideCells;
  samples_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), {});
  const Eigen::Matrix3f rotation = cloud.T_world_camera().linear().cast<float>();
  const Eigen::Vector3f camera_world = cloud.T_world_camera().translation().cast<float>();
  const PinholeCamera& camera = cloud.camera();
  const auto stride2 = static_cast<float>(kStrideCells * kStrideCells);
  const float area_at_1m = stride2 / static_cast<float>(camera.fx * camera.fy);
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const int u = column * kStrideCells;
      const int v = row * kStrideCells;
      const SurfaceCell& cell = cloud.At(u, v);
      if (!(cell.weight > 0.0F) || !cloud.HasPlaneAt(u, v)) continue;
      SurfaceSample& sample = samples_[Index(column, row)];
      const Eigen::Vector3f normal_camera(cell.normal_x, cell.normal_y, cell.normal_z);
      const Eigen::Vector3f ray = camera.Ray(u, v).cast<float>();
      const float cosine = normal_camera.dot(ray) / ray.norm();
      sample.position_world = camera_world + rotation * (ray * cell.depth_m);
      sample.normal_world = -(rotation * normal_camera);
      sample.depth_m = cell.depth_m;
      sample.area_m2 =
          area_at_1m * cell.depth_m * cell.depth_m / std::max(cosine, kMinFacingCosine);
      sample.label = MajorityLabel(cloud, u, v);
      sample.instance = cloud.InstanceAt(u, v);
    }
  }
}

bool AreConnected(const SurfaceSample& a, const SurfaceSample& b) {
  if (!a.is_valid() || !b.is_valid()) return false;
  const Eigen::Vector3f way = b.position_world - a.position_world;
  const float max_gap_m = kMaxGapM + kMaxGapPerMetre * std::min(a.depth_m, b.depth_m);
  if (way.squaredNorm() < max_gap_m * max_gap_m) return true;
  // On a surface seen at a flat angle neighbours are far apart, but in one plane.
  return std::abs(way.dot(a.normal_world)) < 0.25F * max_gap_m &&
         std::abs(way.dot(b.normal_world)) < 0.25F * max_gap_m &&
         way.squaredNorm() < 9.0F * max_gap_m * max_gap_m;
}

}  // namespace steadymap
