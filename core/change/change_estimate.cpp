#include "core/change/change_estimate.h"

#include <algorithm>
#include <cmath>

namespace steadymap {
namespace {

/// Integral of `z^2` from 0: voxels of the ray of a pixel of unit size up to a depth.
double VoxelsUpTo(double depth_m) { return depth_m * depth_m * depth_m / 3.0; }

/// Integral of `z^3` from 0.
double DepthsUpTo(double depth_m) { return depth_m * depth_m * depth_m * depth_m / 4.0; }

bool IsSurface(double depth_m) { return depth_m > 0.0 && std::isfinite(depth_m); }

}  // namespace

void ChangeSum::AddRay(double object_depth_m, double observed_depth_m) {
  if (!IsSurface(object_depth_m) || !IsSurface(observed_depth_m)) return;
  const double near_m = std::min(object_depth_m, observed_depth_m);
  const double apart_m = std::abs(object_depth_m - observed_depth_m);

  // Voxels nearer than `floor_m` are beyond the truncation of both surfaces; from there to `full_m`
  // the distance of the farther surface is clamped, so the difference is `z - floor_m`.
  const double floor_m = near_m - parameters_.truncation_m;
  const double start_m = std::max(floor_m, 0.0);
  const double full_m = std::clamp(floor_m + apart_m, start_m, near_m);
  const double voxels = VoxelsUpTo(near_m) - VoxelsUpTo(start_m);
  double difference = apart_m * (VoxelsUpTo(near_m) - VoxelsUpTo(full_m));
  if (full_m > start_m) {
    difference += DepthsUpTo(full_m) - DepthsUpTo(start_m) -
                  floor_m * (VoxelsUpTo(full_m) - VoxelsUpTo(start_m));
  }
  voxels_ += voxels;
  difference_ += difference;
}

std::optional<double> ChangeSum::Change() const {
  if (!(voxels_ > 0.0)) return std::nullopt;
  return parameters_.change_scale * difference_ / voxels_;
}

}  // namespace steadymap
