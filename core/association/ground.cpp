#include "core/association/ground.h"

#include <cmath>
#include <map>

namespace steadymap {
namespace {

constexpr float kUpright = 0.9F;
constexpr double kLevelM = 0.04;
constexpr double kMinArea = 0.3;  // Square metres of one level.

// What is seen further below than noise reaches, square metres.
constexpr double kBelowM = 0.12;
constexpr double kMaxAreaBelow = 0.05;

// Samples this close to the ground are ground if they face up; nearer still, in any case: the foot
// of a wall.
constexpr double kNearGroundM = 0.05;
constexpr double kNearGroundPerMetre = 0.012;
constexpr double kFootM = 0.02;

}  // namespace

std::optional<double> FindGroundHeight(const SampleGrid& samples, double camera_height_m) {
  std::map<int, double> area_by_level;
  std::map<int, double> flat_area_by_level;
  for (std::size_t index = 0; index < samples.size(); ++index) {
    const SurfaceSample& sample = samples[index];
    const auto height_m = static_cast<double>(sample.position_world.z());
    if (!sample.is_valid() || height_m > camera_height_m - 0.1) continue;
    const int level = static_cast<int>(std::floor(height_m / kLevelM));
    area_by_level[level] += static_cast<double>(sample.area_m2);
    if (sample.normal_world.z() < kUpright) continue;
    flat_area_by_level[level] += static_cast<double>(sample.area_m2);
  }
  for (const auto& [level, area] : flat_area_by_level) {
    const auto above = flat_area_by_level.find(level + 1);
    const double next_area = above == flat_area_by_level.end() ? 0.0 : above->second;
    if (area + next_area < kMinArea) continue;
    const double height_m = kLevelM * (level + (0.5 * area + 1.5 * next_area) / (area + next_area));
    double area_below = 0.0;
    for (const auto& [lower, lower_area] : area_by_level) {
      if (kLevelM * (lower + 1) > height_m - kBelowM) break;
      area_below += lower_area;
    }
    if (area_below > kMaxAreaBelow) return std::nullopt;
    return height_m;
  }
  return std::nullopt;
}

void AssignGround(const SampleGrid& samples, double ground_height_m, Association* association) {
  for (std::size_t index = 0; index < samples.size(); ++index) {
    const SurfaceSample& sample = samples[index];
    if (!sample.is_valid()) continue;
    const double height_m = static_cast<double>(sample.position_world.z()) - ground_height_m;
    const double near_m = kNearGroundM + kNearGroundPerMetre * static_cast<double>(sample.depth_m);
    const bool is_flat = sample.normal_world.z() > kUpright - 0.1F;
    if (height_m < kFootM || (is_flat && height_m < near_m)) {
      association->owner[index] = kBackgroundOwner;
    }
  }
}

}  // namespace steadymap
