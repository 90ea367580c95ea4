#pragma once

#include <cstdint>
#include <vector>

#include "client/bench/simulator/sensor/renderer.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"
#include "core/geometry/geometry.h"

namespace steadymap {

/// Turns true depths into what the sensor reports. Each pixel's noise depends on the key and the
/// pixel only. Holds its buffers; one thread at a time.
class DepthSensor {
 public:
  DepthSensor(const SensorModel& sensor, const PinholeCamera& camera);

  /// Depth in millimetres, 0 where there is no return, with every noise that the model switches on.
  /// `surfaces` must have the camera's size.
  Image<std::uint16_t> Measure(const SurfaceImage& surfaces, std::uint64_t noise_key);

 private:
  using Row = std::vector<float>;

  /// True depths of row `v`, metres, 0 for nothing, without the border columns around it.
  void LoadRow(const SurfaceImage& surfaces, int v, Row* row) const;
  void HashRow(std::uint64_t key, int v);
  void FloatPixelsAtEdges(const Row& above, const Row& row, const Row& below);
  void AddGaussianNoise();
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
};

}  // namespace steadymap
