#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace steadymap {

/// Noise that changes slowly over image and time, such as the warp of a depth camera: a field of
/// values that are standard normal at each pixel and time. Values at least two `kSpacingPx` apart
/// along an axis, or two `kPeriodS` apart in time, are independent.
class CorrelatedNoise {
 public:
  static constexpr int kSpacingPx = 32;
  static constexpr double kPeriodS = 1.0;

  CorrelatedNoise(int width_px, int height_px);

  /// Computes the field at a time, which depends only on the arguments.
  void SetMoment(std::uint64_t key, double time_s);

  /// Returns the values of row `v`, one for each pixel. Valid until the next call.
  std::span<const float> Row(int v);

 private:
  int columns_;  ///< Of the lattice.
  int rows_;
  std::vector<float> lattice_;
  std::vector<float> row_;
};

}  // namespace steadymap
