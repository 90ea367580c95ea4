#include "client/bench/simulator/sensor/correlated_noise.h"

#include <cmath>
#include <cstddef>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

/// Returns a standard normal value (Box and Muller, 1958).
double NormalOf(std::uint64_t key) {
  const double radius = std::sqrt(-2.0 * std::log1p(-UniformBetween(key, 0, 0.0, 1.0)));
  return radius * std::cos(UniformBetween(key, 1, 0.0, 2 * M_PI));
}

}  // namespace

CorrelatedNoise::CorrelatedNoise(int width_px, int height_px)
    : columns_(width_px / kSpacingPx + 2), rows_(height_px / kSpacingPx + 2) {
  lattice_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  row_.resize(static_cast<std::size_t>(width_px));
}

void CorrelatedNoise::SetMoment(std::uint64_t key, double time_s) {
  const double period = std::floor(time_s / kPeriodS);
  const double angle_rad = 0.5 * M_PI * (time_s / kPeriodS - period);
  const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(period));
  const std::uint64_t before = Combine(key, number);
  const std::uint64_t after = Combine(key, number + 1);
  for (std::size_t i = 0; i < lattice_.size(); ++i) {
    // The squares of the two weights add up to one, as the variances do.
    lattice_[i] = static_cast<float>(std::cos(angle_rad) * NormalOf(Combine(before, i)) +
                                     std::sin(angle_rad) * NormalOf(Combine(after, i)));
  }
}

std::span<const float> CorrelatedNoise::Row(int v) {
  const float* above =
      &lattice_[static_cast<std::size_t>(v / kSpacingPx) * static_cast<std::size_t>(columns_)];
  const float* below = above + columns_;
  const auto down = static_cast<float>(v % kSpacingPx) / static_cast<float>(kSpacingPx);
  for (std::size_t u = 0; u < row_.size(); ++u) {
    const std::size_t column = u / kSpacingPx;
    const auto right = static_cast<float>(u % kSpacingPx) / static_cast<float>(kSpacingPx);
    const float value = (1 - down) * ((1 - right) * above[column] + right * above[column + 1]) +
                        down * ((1 - right) * below[column] + right * below[column + 1]);
    const float variance =
        ((1 - down) * (1 - down) + down * down) * ((1 - right) * (1 - right) + right * right);
    row_[u] = value / std::sqrt(variance);
  }
  return row_;
}

}  // namespace steadymap
