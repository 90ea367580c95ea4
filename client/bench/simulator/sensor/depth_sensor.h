#pragma once

#include <cstdint>
#include <vector>

#include "client/bench/simulator/sensor/correlated_noise.h"
#include "client/bench/simulator/sensor/renderer.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// What the noise of one frame depends on.
struct NoiseMoment {
  std::uint64_t frame_key = 0;  ///< Of noise that differs from frame to frame.
  std::uint64_t slow_key = 0;   ///< Of noise that changes slowly; the same for all frames,
  double time_s = 0.0;          ///< at this time.
};

/// Adds sensor noise to true depths. The noise of a pixel depends only on the moment and the pixel.
/// Reuses its buffers; not thread-safe.
class DepthSensor {
 public:
  DepthSensor(const SensorModel& sensor, const PinholeCamera& camera);

  /// Returns the depth in millimetres, 0 without a return, with every noise that the model enables.
  /// `surfaces` must have the camera's size.
  Image<std::uint16_t> Measure(const SurfaceImage& surfaces, const NoiseMoment& moment);

 private:
  using Row = std::vector<float>;

  /// Copies the true depths of row `v`, metres, 0 without surface, to the columns inside the
  /// padding.
  void LoadRow(const SurfaceImage& surfaces, int v, Row* row) const;
  void HashRow(std::uint64_t key, int v);
  void FloatPixelsAtEdges(const Row& above, const Row& row, const Row& below);
  void FattenForeground(const Row& row);
  void AddGaussianNoise();
  void AddCorrelatedNoise(int v);
  float SigmaAt(float depth_m) const;
  void RoundToDisparitySteps();
  void DropGrazingPixels(const SurfaceImage& surfaces, int v);
  void StoreRow(int v, Image<std::uint16_t>* depth) const;
  void PunchHoles(std::uint64_t key, Image<std::uint16_t>* depth) const;

  SensorModel sensor_;
  PinholeCamera camera_;
  std::vector<float> inverse_ray_length_;  ///< 1 / |ray| of each pixel, row-major.
  Row above_, row_, below_;                ///< True depths with one column of padding on each side.
  Row measured_m_;
  Row jump_m_;
  std::vector<std::uint64_t> hashes_;
  CorrelatedNoise correlated_;
};

}  // namespace steadymap
