#include "client/bench/simulator/sensor/label_noise.h"

#include <algorithm>
#include <cmath>

#include "client/bench/simulator/scene/counter_random.h"

namespace steadymap {
namespace {

constexpr std::uint64_t kFlipStream = 3;
constexpr std::uint64_t kBlobStream = 4;
constexpr std::uint64_t kBoundaryStream = 5;

constexpr std::uint64_t kMaxBlobs = 4;
constexpr double kMinBlobRadiusPx = 8.0;
constexpr double kMaxBlobRadiusPx = 30.0;

// Returns any class, or 0 with the probability that the model has for it.
std::uint16_t AnyClass(const SensorModel& sensor, std::uint64_t key) {
  if (UniformBetween(key, 9, 0.0, 1.0) < sensor.unlabelled_share) return 0;
  return static_cast<std::uint16_t>(1 + Scramble(key) % (kSceneClassCount - 1));
}

void AddBlob(const SensorModel& sensor, std::uint64_t key, Image<std::uint16_t>* labels) {
  const double center_u = UniformBetween(key, 1, 0, labels->width_px());
  const double center_v = UniformBetween(key, 2, 0, labels->height_px());
  const double radius_u = UniformBetween(key, 3, kMinBlobRadiusPx, kMaxBlobRadiusPx);
  const double radius_v = UniformBetween(key, 4, kMinBlobRadiusPx, kMaxBlobRadiusPx);
  const std::uint16_t label = AnyClass(sensor, key);
  const int first_v = std::max(0, static_cast<int>(std::ceil(center_v - radius_v)));
  const int last_v = std::min(labels->height_px() - 1, static_cast<int>(center_v + radius_v));
  for (int v = first_v; v <= last_v; ++v) {
    const double height = (v - center_v) / radius_v;
    const double half = radius_u * std::sqrt(std::max(0.0, 1 - height * height));
    const int first_u = std::max(0, static_cast<int>(std::ceil(center_u - half)));
    const int last_u = std::min(labels->width_px() - 1, static_cast<int>(center_u + half));
    for (int u = first_u; u <= last_u; ++u) labels->At(u, v) = label;
  }
}

// Returns the label across the nearest border within `reach` pixels, or the pixel's own.
std::uint16_t LabelAcross(const Image<std::uint16_t>& labels, int u, int v, int reach) {
  const std::uint16_t own = labels.At(u, v);
  for (int step = 1; step <= reach; ++step) {
    const int left = std::max(u - step, 0);
    const int right = std::min(u + step, labels.width_px() - 1);
    const int above = std::max(v - step, 0);
    const int below = std::min(v + step, labels.height_px() - 1);
    for (const std::uint16_t other :
         {labels.At(left, v), labels.At(right, v), labels.At(u, above), labels.At(u, below)}) {
      if (other != own) return other;
    }
  }
  return own;
}

void FrayBorders(const SensorModel& sensor, std::uint64_t key, Image<std::uint16_t>* labels) {
  const Image<std::uint16_t> clean = *labels;
  const double share = std::clamp(sensor.label_boundary_share, 0.0, 1.0);
  if (share <= 0) return;
  // Draws the distance to the next chosen pixel instead of one decision per pixel: the same
  // distribution at a twentieth of the cost.
  const double scale = share < 1 ? 1 / std::log1p(-share) : 0.0;
  std::uint64_t draw = key;
  const auto size = static_cast<double>(clean.size());
  double pixel = -1.0;
  while (true) {
    draw = Combine(draw, 0);
    pixel += 1 + std::floor(std::log1p(-UniformOf(draw)) * scale);
    if (pixel >= size) return;
    const auto index = static_cast<int>(pixel);
    const int u = index % clean.width_px();
    const int v = index / clean.width_px();
    labels->At(u, v) = LabelAcross(clean, u, v, sensor.label_boundary_px);
  }
}

}  // namespace

std::uint16_t ShownClass(const SensorModel& sensor,
                         std::uint64_t noise_key,
                         const SceneObject& object) {
  const auto own = static_cast<std::uint16_t>(object.semantic_class);
  if (!sensor.label_flips || object.instance == 0) return own;
  const std::uint64_t key = Combine(Combine(noise_key, kFlipStream), object.id);
  if (UniformOf(key) >= sensor.label_flip_share) return own;
  const std::uint16_t other = AnyClass(sensor, key);
  return other != own ? other : static_cast<std::uint16_t>(1 + own % (kSceneClassCount - 1));
}

void AddLabelNoise(const SensorModel& sensor,
                   std::uint64_t noise_key,
                   Image<std::uint16_t>* labels) {
  if (sensor.label_blobs) {
    const double chance = sensor.label_blobs_a_frame / static_cast<double>(kMaxBlobs);
    for (std::uint64_t i = 0; i < kMaxBlobs; ++i) {
      const std::uint64_t key = Combine(Combine(noise_key, kBlobStream), i);
      if (UniformOf(key) < chance) AddBlob(sensor, key, labels);
    }
  }
  if (sensor.label_boundary_noise) {
    FrayBorders(sensor, Combine(noise_key, kBoundaryStream), labels);
  }
}

}  // namespace steadymap
