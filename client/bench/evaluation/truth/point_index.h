#pragma once

#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "client/bench/evaluation/truth/surface_points.h"
#include "client/bench/evaluation/truth/voxel_index.h"

namespace steadymap {

/// Points in cubic cells, for radius queries.
class PointIndex {
 public:
  /// Radius of the queries, > 0.
  explicit PointIndex(double reach_m) : reach_m_(reach_m) {}

  void Add(const Eigen::Vector3f& point_world);
  void Add(const std::vector<SurfacePoint>& points);

  /// True if a point lies within `reach_m` of `point_world`. Cost: some tens of ns in empty space,
  /// up to some us among many points just outside the radius.
  bool HasNear(const Eigen::Vector3f& point_world) const;

 private:
  double reach_m_;
  std::unordered_map<VoxelIndex, std::vector<Eigen::Vector3f>> cells_;  ///< Edge: the radius.
};

}  // namespace steadymap
