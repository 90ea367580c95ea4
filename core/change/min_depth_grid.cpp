#include "core/change/min_depth_grid.h"

#include <algorithm>
#include <limits>

namespace steadymap {
namespace {

/// The returns of one tile.
struct TileReturns {
  std::uint32_t nearest = std::numeric_limits<std::uint32_t>::max();  ///< Sensor units.
  int count = 0;
};

TileReturns ReadTile(const Image<std::uint16_t>& units, int column, int row) {
  TileReturns tile;
  for (int v = row * MinDepthGrid::kTilePx; v < (row + 1) * MinDepthGrid::kTilePx; ++v) {
    const std::uint16_t* pixels = &units.At(column * MinDepthGrid::kTilePx, v);
    for (std::size_t u = 0; u < MinDepthGrid::kTilePx; ++u) {
      if (pixels[u] == kNoDepth || pixels[u] == kInvalidDepth) continue;
      tile.nearest = std::min<std::uint32_t>(tile.nearest, pixels[u]);
      ++tile.count;
    }
  }
  return tile;
}

}  // namespace

void MinDepthGrid::Compute(const DepthImage& depth) {
  width_ = depth.units.width_px() / kTilePx;
  height_ = depth.units.height_px() / kTilePx;
  nearest_m_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0.0F);
  is_measured_.assign(nearest_m_.size(), 0);
  farthest_m_ = 0.0F;
  const auto metres_per_unit = static_cast<float>(depth.metres_per_unit);
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const TileReturns tile = ReadTile(depth.units, column, row);
      const std::size_t index = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                static_cast<std::size_t>(column);
      is_measured_[index] = 2 * tile.count >= kTilePx * kTilePx ? 1 : 0;
      nearest_m_[index] = std::numeric_limits<float>::infinity();
      if (tile.count == 0) continue;
      nearest_m_[index] = static_cast<float>(tile.nearest) * metres_per_unit;
      farthest_m_ = std::max(farthest_m_, nearest_m_[index]);
    }
  }
}

float MinDepthGrid::NearestAround(int column, int row) const {
  const auto index = [this](int u, int v) {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(u);
  };
  if (column < 1 || row < 1 || column + 1 >= width_ || row + 1 >= height_ ||
      is_measured_[index(column, row)] == 0) {
    return 0.0F;
  }
  float nearest_m = std::numeric_limits<float>::infinity();
  for (int v = row - 1; v <= row + 1; ++v) {
    for (int u = column - 1; u <= column + 1; ++u) {
      nearest_m = std::min(nearest_m, nearest_m_[index(u, v)]);
    }
  }
  return nearest_m;
}

}  // namespace steadymap
