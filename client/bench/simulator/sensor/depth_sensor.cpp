#include "client/bench/simulator/sensor/depth_sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kPixelStream = 1;
constexpr std::uint64_t kHoleStream = 2;

constexpr float kMillimetresPerMetre = 1000.0F;

// Holes are discs.
constexpr double kMinHoleRadiusPx = 3.0;
constexpr double kMaxHoleRadiusPx = 9.0;

// Use of a pixel's 64 random bits: 12 for the Gaussian, 16 for each binary decision and for the
// depth of a flying pixel.
constexpr std::size_t kNormalBits = 12;
constexpr std::size_t kNormalCount = std::size_t{1} << kNormalBits;

// Rounds a number >= 0. `lround` would be a function call per pixel.
int RoundPositive(float number) {
  const float shifted = number + 0.5F;
  return static_cast<int>(shifted);
}

float UnitFromBits(std::uint64_t hash, int shift) {
  return static_cast<float>((hash >> shift) & 0xffffU) * (1.0F / 65536.0F);
}

float FlyingDice(std::uint64_t hash) { return UnitFromBits(hash, 12); }

float FlyingMix(std::uint64_t hash) { return UnitFromBits(hash, 28); }

float GrazingDice(std::uint64_t hash) { return UnitFromBits(hash, 44); }

// Returns a quantile of the standard normal distribution, by bisection of its distribution
// function.
double NormalQuantile(double probability) {
  double low = -8.0;
  double high = 8.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (0.5 * std::erfc(-middle / M_SQRT2) < probability ? low : high) = middle;
  }
  return (low + high) / 2;
}

// Equally likely values of a standard normal variable; one lookup is one draw.
const std::array<float, kNormalCount>& NormalDraws() {
  static const std::array<float, kNormalCount> draws = [] {
    std::array<float, kNormalCount> values{};
    for (std::size_t i = 0; i < kNormalCount; ++i) {
      values[i] = static_cast<float>(
          NormalQuantile((static_cast<double>(i) + 0.5) / static_cast<double>(kNormalCount)));
    }
    return values;
  }();
  return draws;
}

}  // namespace

DepthSensor::DepthSensor(const SensorModel& sensor, const PinholeCamera& camera)
    : sensor_(sensor), camera_(camera), correlated_(camera.width_px, camera.height_px) {
  const auto width = static_cast<std::size_t>(camera.width_px);
  for (Row* row : {&above_, &row_, &below_}) row->assign(width + 2, 0.0F);
  measured_m_.resize(width);
  jump_m_.resize(width);
  hashes_.resize(width);
  inverse_ray_length_.reserve(width * static_cast<std::size_t>(camera.height_px));
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      inverse_ray_length_.push_back(static_cast<float>(1 / camera.Ray(u, v).norm()));
    }
  }
}

Image<std::uint16_t> DepthSensor::Measure(const SurfaceImage& surfaces, const NoiseMoment& moment) {
  Image<std::uint16_t> depth(camera_.width_px, camera_.height_px);
  const std::uint64_t pixel_key = Combine(moment.frame_key, kPixelStream);
  const bool needs_hash = sensor_.flying_pixels || sensor_.depth_noise || sensor_.grazing_dropout;
  if (sensor_.correlated_noise) correlated_.SetMoment(moment.slow_key, moment.time_s);
  LoadRow(surfaces, 0, &above_);
  LoadRow(surfaces, 0, &row_);
  for (int v = 0; v < camera_.height_px; ++v) {
    LoadRow(surfaces, std::min(v + 1, camera_.height_px - 1), &below_);
    std::copy(row_.begin() + 1, row_.end() - 1, measured_m_.begin());
    if (needs_hash) HashRow(pixel_key, v);
    if (sensor_.foreground_fattening) FattenForeground(row_);
    if (sensor_.flying_pixels) FloatPixelsAtEdges(above_, row_, below_);
    if (sensor_.depth_noise) AddGaussianNoise();
    if (sensor_.correlated_noise) AddCorrelatedNoise(v);
    if (sensor_.disparity_steps) RoundToDisparitySteps();
    if (sensor_.grazing_dropout) DropGrazingPixels(surfaces, v);
    StoreRow(v, &depth);
    std::swap(above_, row_);
    std::swap(row_, below_);
  }
  if (sensor_.holes) PunchHoles(Combine(moment.frame_key, kHoleStream), &depth);
  return depth;
}

void DepthSensor::LoadRow(const SurfaceImage& surfaces, int v, Row* row) const {
  const float* inverse_depth = &surfaces.pixels.inverse_depth_per_m.At(0, v);
  float* depth_m = row->data() + 1;
  for (int u = 0; u < camera_.width_px; ++u) {
    depth_m[u] = inverse_depth[u] > 0.0F ? 1.0F / inverse_depth[u] : 0.0F;
  }
  // The padding repeats the border and so creates no edge.
  row->front() = depth_m[0];
  row->back() = depth_m[camera_.width_px - 1];
}

void DepthSensor::HashRow(std::uint64_t key, int v) {
  const std::uint64_t first =
      static_cast<std::uint64_t>(v) * static_cast<std::uint64_t>(camera_.width_px);
  for (std::size_t u = 0; u < hashes_.size(); ++u) hashes_[u] = Combine(key, first + u);
}

void DepthSensor::FloatPixelsAtEdges(const Row& above, const Row& row, const Row& below) {
  const std::size_t width = measured_m_.size();
  for (std::size_t u = 0; u < width; ++u) {
    const float depth_m = row[u + 1];
    const float across = std::max(std::abs(row[u] - depth_m), std::abs(row[u + 2] - depth_m));
    const float along =
        std::max(std::abs(above[u + 1] - depth_m), std::abs(below[u + 1] - depth_m));
    jump_m_[u] = std::max(across, along);
  }
  const auto threshold_m = static_cast<float>(sensor_.flying_pixel_jump_m);
  const auto share = static_cast<float>(sensor_.flying_pixel_share);
  for (std::size_t u = 0; u < width; ++u) {
    if (jump_m_[u] <= threshold_m || FlyingDice(hashes_[u]) >= share) continue;
    const float depth_m = row[u + 1];
    for (const float other_m : {row[u], row[u + 2], above[u + 1], below[u + 1]}) {
      if (other_m > 0.0F && depth_m > 0.0F && std::abs(other_m - depth_m) > threshold_m) {
        measured_m_[u] = depth_m + (other_m - depth_m) * FlyingMix(hashes_[u]);
        break;
      }
    }
  }
}

/// Gives pixels near the edge of a nearer surface its depth, as block matching does.
void DepthSensor::FattenForeground(const Row& row) {
  const auto threshold_m = static_cast<float>(sensor_.flying_pixel_jump_m);
  const auto width = static_cast<int>(measured_m_.size());
  for (int u = 0; u < width; ++u) {
    const float depth_m = row[static_cast<std::size_t>(u) + 1];
    float nearest_m = depth_m;
    const int last = std::min(u + sensor_.fattening_px, width - 1);
    for (int other = std::max(u - sensor_.fattening_px, 0); other <= last; ++other) {
      const float other_m = row[static_cast<std::size_t>(other) + 1];
      if (other_m > 0.0F && other_m < nearest_m - threshold_m) nearest_m = other_m;
    }
    measured_m_[static_cast<std::size_t>(u)] = nearest_m;
  }
}

float DepthSensor::SigmaAt(float depth_m) const {
  const auto near_m = static_cast<float>(sensor_.depth_noise_at_one_metre_m);
  const auto growth = static_cast<float>(sensor_.depth_noise_growth_m);
  const auto share = static_cast<float>(sensor_.range_noise_share);
  const float square = depth_m * depth_m;
  return near_m * std::min(square, 1.0F) + growth * std::max(square - 1.0F, 0.0F) + share * depth_m;
}

void DepthSensor::AddGaussianNoise() {
  const std::array<float, kNormalCount>& normal = NormalDraws();
  for (std::size_t u = 0; u < measured_m_.size(); ++u) {
    measured_m_[u] += SigmaAt(measured_m_[u]) * normal[hashes_[u] % kNormalCount];
  }
}

void DepthSensor::AddCorrelatedNoise(int v) {
  const auto share = static_cast<float>(sensor_.correlated_noise_share);
  const std::span<const float> slow = correlated_.Row(v);
  for (std::size_t u = 0; u < measured_m_.size(); ++u) {
    measured_m_[u] += share * SigmaAt(measured_m_[u]) * slow[u];
  }
}

void DepthSensor::RoundToDisparitySteps() {
  const auto steps_metres =
      static_cast<float>(camera_.fx * sensor_.stereo_baseline_m / sensor_.disparity_step_px);
  // Keeps the quotients within an int; such depths are out of range anyway.
  constexpr float kNearestM = 1e-3F;
  constexpr float kLeastSteps = 0.5F;
  for (float& depth_m : measured_m_) {
    const float steps = std::max(steps_metres / std::max(depth_m, kNearestM), kLeastSteps);
    const float rounded_m = steps_metres / static_cast<float>(RoundPositive(steps));
    depth_m = depth_m > 0.0F ? rounded_m : 0.0F;
  }
}

void DepthSensor::DropGrazingPixels(const SurfaceImage& surfaces, int v) {
  const auto limit = static_cast<float>(sensor_.grazing_cosine);
  const float* inverse_depth = &surfaces.pixels.inverse_depth_per_m.At(0, v);
  const std::uint32_t* surface = &surfaces.pixels.surface.At(0, v);
  const float* inverse_length =
      &inverse_ray_length_[static_cast<std::size_t>(v) * measured_m_.size()];
  for (std::size_t u = 0; u < measured_m_.size(); ++u) {
    // normal . ray = plane distance / depth, for a ray with z = 1.
    const float cosine =
        surfaces.surfaces[surface[u]].plane_distance_m * inverse_depth[u] * inverse_length[u];
    if (cosine < limit * (1.0F - GrazingDice(hashes_[u]))) measured_m_[u] = 0.0F;
  }
}

void DepthSensor::StoreRow(int v, Image<std::uint16_t>* depth) const {
  const auto nearest_m = static_cast<float>(sensor_.min_range_m);
  const auto farthest_m = static_cast<float>(sensor_.max_range_m);
  std::uint16_t* units = &depth->At(0, v);
  for (std::size_t u = 0; u < measured_m_.size(); ++u) {
    const float depth_m = measured_m_[u];
    const float kept_m = depth_m >= nearest_m && depth_m <= farthest_m ? depth_m : 0.0F;
    units[u] = static_cast<std::uint16_t>(RoundPositive(kept_m * kMillimetresPerMetre));
  }
}

void DepthSensor::PunchHoles(std::uint64_t key, Image<std::uint16_t>* depth) const {
  const double share = UniformBetween(key, 0, sensor_.min_hole_share, sensor_.max_hole_share);
  const double wanted_px = share * static_cast<double>(depth->size());
  std::uint64_t hole = key;
  for (double lost_px = 0.0; lost_px < wanted_px;) {
    hole = Combine(hole, 1);
    const double center_u = UniformBetween(hole, 1, 0, camera_.width_px - 1);
    const double center_v = UniformBetween(hole, 2, 0, camera_.height_px - 1);
    const double radius = UniformBetween(hole, 3, kMinHoleRadiusPx, kMaxHoleRadiusPx);
    const int first_v = std::max(0, static_cast<int>(std::ceil(center_v - radius)));
    const int last_v = std::min(camera_.height_px - 1, static_cast<int>(center_v + radius));
    for (int v = first_v; v <= last_v; ++v) {
      const double height = v - center_v;
      const double half = std::sqrt(std::max(0.0, radius * radius - height * height));
      const int first_u = std::max(0, static_cast<int>(std::ceil(center_u - half)));
      const int last_u = std::min(camera_.width_px - 1, static_cast<int>(center_u + half));
      for (int u = first_u; u <= last_u; ++u) depth->At(u, v) = kNoDepth;
      lost_px += std::max(0, last_u - first_u + 1);
    }
  }
}

}  // namespace steadymap
