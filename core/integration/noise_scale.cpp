#include "core/integration/noise_scale.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace steadymap {
namespace {

// Some thousand differences determine the median to two percent.
constexpr int kStridePx = 8;

// Median magnitude of a normal distribution, in its standard deviation.
constexpr double kMedianOfNormal = 0.6745;

}  // namespace

double MeasureNoiseScale(const DepthImage& depth, const DepthNoise& noise) {
  std::vector<double> magnitudes;
  const auto depth_at = [&depth](int column, int row) {
    const std::uint16_t units = depth.units.At(column, row);
    return units == 65535 ? 0.0 : static_cast<double>(units) * depth.metres_per_unit;
  };
  for (int row = 0; row < depth.units.height_px(); row += kStridePx) {
    for (int column = 1; column + 1 < depth.units.width_px(); column += kStridePx) {
      const double before_m = depth_at(column - 1, row);
      const double here_m = depth_at(column, row);
      const double after_m = depth_at(column + 1, row);
      if (before_m <= 0.0 || here_m <= 0.0 || after_m <= 0.0) continue;
      const double sigma_m = std::sqrt(6.0) * noise.SigmaM(here_m);
      magnitudes.push_back(std::abs(before_m - 2.0 * here_m + after_m) / sigma_m);
    }
  }
  if (magnitudes.empty()) return 0.0;
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return *middle / kMedianOfNormal;
}

}  // namespace steadymap
