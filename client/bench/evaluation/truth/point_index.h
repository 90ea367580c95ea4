#pragma once

#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "client/bench/evaluation/truth/surface_points.h"
#include "client/bench/evaluation/truth/voxel_index.h"

namespace steadymap {

/// Points sorted into cubic cells, to ask whether there is one near.
class PointIndex {
 public:
  /// Asks for distances up to `reach_m`, > 0.
  explicit PointIndex(double reach_m) : reach_m_(reach_m) {}

  void Add(const Eigen::Vector3f& point_world);
  void Add(const std::vector<SurfacePoint>& points);

  /// Whether a point lies within `reach_m` of `point_world`. Cost: some tens of ns where there is
  /// nothing around, up to some us among many points that just miss.
  bool HasNear(const Eigen::Vector3f& point_world) const;

 private:
  double reach_m_;
  std::unordered_map<VoxelIndex, std::vector<Eigen::Vector3f>> cells_;  ///< Edge: the reach.
};

}  // namespace steadymap
