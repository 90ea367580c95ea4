#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "core/objects/surface_parts.h"

namespace steadymap {

/// Returns a key of a voxel or cell, unique within 2^20 cells of the origin.
inline std::uint64_t KeyOf(const Eigen::Vector3i& index) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
  const auto part = [](int value) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) & kMask;
  };
  return part(index.x()) << 42 | part(index.y()) << 21 | part(index.z());
}

/// Points in cubes of a grid, for the search of neighbours. `points` must outlive the grid.
class PointGrid {
 public:
  PointGrid(std::span<const OrientedPoint> points, double reach_m)
      : points_(points), reach_m_(reach_m) {
    cells_.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      cells_[KeyOf(CellOf(points[i].position_world))].push_back(i);
    }
  }

  /// Calls `visit` with the index of each point within the reach of a place.
  template <typename Visit>
  void ForEachNear(const Eigen::Vector3d& position_world, Visit visit) const {
    const Eigen::Vector3i cell = CellOf(position_world);
    for (int i = 0; i < kNeighbourCells; ++i) {
      const Eigen::Vector3i step(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
      const auto found = cells_.find(KeyOf(cell + step));
      if (found == cells_.end()) continue;
      for (const std::size_t other : found->second) {
        if ((points_[other].position_world - position_world).norm() <= reach_m_) visit(other);
      }
    }
  }

  /// Calls `visit` with the index of each point within the reach of a point, itself included.
  template <typename Visit>
  void ForEachNeighbour(std::size_t index, Visit visit) const {
    ForEachNear(points_[index].position_world, visit);
  }

 private:
  // A cell with its neighbours.
  static constexpr int kNeighbourCells = 27;

  Eigen::Vector3i CellOf(const Eigen::Vector3d& position_world) const {
    return (position_world / reach_m_).array().floor().cast<int>();
  }

  std::span<const OrientedPoint> points_;
  double reach_m_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

}  // namespace steadymap
