#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

#include <Eigen/Core>

namespace steadymap {

/// A cube of a grid of space, by its lowest corner in edges.
struct CellIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const CellIndex&, const CellIndex&) = default;
};

/// The cube that holds a point; `point_cells` in edges.
inline CellIndex CellAt(const Eigen::Vector3d& point_cells) {
  return {static_cast<std::int32_t>(std::floor(point_cells.x())),
          static_cast<std::int32_t>(std::floor(point_cells.y())),
          static_cast<std::int32_t>(std::floor(point_cells.z()))};
}

}  // namespace steadymap
