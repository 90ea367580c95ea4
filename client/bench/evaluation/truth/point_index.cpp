#include "client/bench/evaluation/truth/point_index.h"

#include <algorithm>

namespace steadymap {

void PointIndex::Add(const Eigen::Vector3f& point_world) {
  cells_[VoxelAt(point_world, reach_m_)].push_back(point_world);
}

void PointIndex::Add(const std::vector<SurfacePoint>& points) {
  for (const SurfacePoint& point : points) Add(point.position_world);
}

bool PointIndex::HasNear(const Eigen::Vector3f& point_world) const {
  const VoxelIndex center = VoxelAt(point_world, reach_m_);
  const auto reach_squared_m2 = static_cast<float>(reach_m_ * reach_m_);
  const auto is_near = [&](const Eigen::Vector3f& other) {
    return (other - point_world).squaredNorm() <= reach_squared_m2;
  };
  const auto has_near = [&](const VoxelIndex& cell) {
    const auto found = cells_.find(cell);
    return found != cells_.end() &&
           std::any_of(found->second.begin(), found->second.end(), is_near);
  };
  if (has_near(center)) return true;
  for (int i = 0; i < 27; ++i) {
    if (i == 13) continue;  // The centre cell was tested first.
    const VoxelIndex cell = {center.x + i / 9 - 1, center.y + i / 3 % 3 - 1, center.z + i % 3 - 1};
    if (has_near(cell)) return true;
  }
  return false;
}

}  // namespace steadymap
