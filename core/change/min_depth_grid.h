#pragma once

#include <cstdint>
#include <vector>

#include "core/association/sample_grid.h"
#include "core/frame/frame.h"

namespace steadymap {

/// Nearest raw depth by tiles of pixels, one tile a sample of the grid. Depth beyond what is fused
/// counts too: one can look through a place from further away than one can map it.
class MinDepthGrid {
 public:
  /// Pixels of a tile's side.
  static constexpr int kTilePx = 2 * SampleGrid::kStrideCells;

  /// What is nearer to the camera is not looked at, metres: few sensors measure it.
  static constexpr float kNearestLookM = 0.1F;

  void Compute(const DepthImage& depth);

  /// Nearest depth in the tile and its eight neighbours, metres; 0 if half of the tile itself has
  /// no return.
  float NearestAround(int column, int row) const;

  /// The greatest depth of any tile, metres; 0 without returns. So far the sensor measures for
  /// sure.
  float farthest_m() const { return farthest_m_; }

 private:
  int width_ = 0;
  int height_ = 0;
  float farthest_m_ = 0.0F;
  std::vector<float> nearest_m_;  ///< Infinite without any return.
  std::vector<std::uint8_t> is_measured_;
};

}  // namespace steadymap
