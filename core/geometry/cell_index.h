#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

#include <Eigen/Core>

namespace steadymap {

/// The index of a cube of a regular grid: its lowest corner, in edge lengths.
struct CellIndex {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend constexpr auto operator<=>(const CellIndex&, const CellIndex&) = default;
};

/// Returns the cube that contains a point; `point_cells` is in edge lengths.
inline CellIndex CellAt(const Eigen::Vector3d& point_cells) {
  return {static_cast<std::int32_t>(std::floor(point_cells.x())),
          static_cast<std::int32_t>(std::floor(point_cells.y())),
          static_cast<std::int32_t>(std::floor(point_cells.z()))};
}

}  // namespace steadymap
