#include "client/bench/evaluation/composite/frame_composer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace steadymap {
namespace {

double DepthM(const DepthImage& depth, int u, int v) {
  const std::uint16_t units = depth.units.At(u, v);
  return units == kNoDepth || units == kInvalidDepth ? 0.0 : units * depth.metres_per_unit;
}

/// True if a thing hides what was recorded. What has no recorded depth is far.
bool IsInFront(double thing_m, double recorded_m) {
  return thing_m > 0.0 && (recorded_m <= 0.0 || thing_m < recorded_m);
}

/// Returns the true depth of the things in each pixel, metres, 0 beside them.
Image<float> DepthOf(const SurfaceImage& surfaces) {
  const Image<float>& inverse_depth = surfaces.pixels.inverse_depth_per_m;
  Image<float> depth_m(inverse_depth.width_px(), inverse_depth.height_px());
  std::transform(inverse_depth.data(),
                 inverse_depth.data() + inverse_depth.size(),
                 depth_m.data(),
                 [](float inverse) { return inverse > 0.0F ? 1.0F / inverse : 0.0F; });
  return depth_m;
}

}  // namespace

SensorModel StructuredLightModel() {
  SensorModel sensor = SensorModel::Ideal();
  sensor.depth_noise = true;
  sensor.depth_noise_at_one_metre_m = 0.0019;
  sensor.depth_noise_growth_m = 0.0019;
  sensor.correlated_noise = true;
  sensor.correlated_noise_share = 0.5;
  sensor.disparity_steps = true;
  sensor.disparity_step_px = 1.0 / 8.0;
  sensor.stereo_baseline_m = 0.075;
  sensor.grazing_dropout = true;
  sensor.min_range_m = 0.5;
  sensor.label_boundary_noise = true;
  return sensor;
}

FrameComposer::FrameComposer(const Scene* things,
                             const PinholeCamera& camera,
                             const SensorModel& sensor)
    : sensor_(sensor), camera_(camera), renderer_(things, camera, sensor) {}

void FrameComposer::DrawInto(std::uint64_t noise_key, RoomLabels labels, Frame* frame) {
  const Image<float> true_m = DepthOf(renderer_.RenderSurfaces(frame->T_world_camera, 0.0));
  View view;
  view.T_world_camera = frame->T_world_camera;
  view.noise_key = noise_key;
  const Frame things = renderer_.Render(view, {.include_instances = true});
  frame->labels = Image<std::uint16_t>(camera_.width_px, camera_.height_px);
  frame->instances = frame->labels;
  Shade(true_m, frame);
  for (int v = 0; v < camera_.height_px; ++v) {
    for (int u = 0; u < camera_.width_px; ++u) {
      if (!IsInFront(static_cast<double>(true_m.At(u, v)), DepthM(frame->depth, u, v))) continue;
      const double units = std::round(DepthM(things.depth, u, v) / frame->depth.metres_per_unit);
      frame->depth.units.At(u, v) =
          static_cast<std::uint16_t>(std::min(units, static_cast<double>(kInvalidDepth - 1)));
      frame->labels.At(u, v) = things.labels.At(u, v);
      frame->instances.At(u, v) = things.instances.At(u, v);
    }
  }
  if (labels == RoomLabels::kNone) frame->labels = {};
  if (labels != RoomLabels::kInstances) frame->instances = {};
}

/// Removes the recorded depth where a thing stands between the surface and the projector, which is
/// to the right of the camera by the baseline: a point at column u and depth z is lit if no thing
/// to the right of it has a smaller u - f b / z.
void FrameComposer::Shade(const Image<float>& thing_m, Frame* frame) const {
  const double disparity_m = camera_.fx * sensor_.stereo_baseline_m;
  for (int v = 0; v < camera_.height_px; ++v) {
    double border = std::numeric_limits<double>::max();
    for (int u = camera_.width_px - 1; u >= 0; --u) {
      const double recorded_m = DepthM(frame->depth, u, v);
      const auto here_m = static_cast<double>(thing_m.At(u, v));
      if (IsInFront(here_m, recorded_m)) {
        border = std::min(border, u - disparity_m / here_m);
      } else if (recorded_m > 0.0 && u - disparity_m / recorded_m > border) {
        frame->depth.units.At(u, v) = kNoDepth;
      }
    }
  }
}

std::size_t FrameComposer::CountVisible(const Frame& frame) {
  const Image<float> true_m = DepthOf(renderer_.RenderSurfaces(frame.T_world_camera, 0.0));
  std::size_t count = 0;
  for (int v = 0; v < camera_.height_px; ++v) {
    for (int u = 0; u < camera_.width_px; ++u) {
      const auto thing_m = static_cast<double>(true_m.At(u, v));
      if (thing_m >= sensor_.min_range_m && IsInFront(thing_m, DepthM(frame.depth, u, v))) ++count;
    }
  }
  return count;
}

}  // namespace steadymap
