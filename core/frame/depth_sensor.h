#pragma once

namespace steadymap {

/// Principle by which a camera measures depth. It determines the noise of the depth.
enum class DepthSensorKind {
  kUnknown,  ///< Not stated; noise between that of structured light and of stereo.
  kStructuredLight,
  kStereo,
  kTimeOfFlight,
  kLidar,  ///< Ranges of a rotating or solid-state lidar, projected into a depth image.
};

/// Noise of depth measurements. The standard deviation at the depth z is
/// `floor_m + growth_per_m * z^2`.
struct DepthNoise {
  double floor_m = 0.0;
  double growth_per_m = 0.0;

  /// Returns the standard deviation at a depth, metres.
  double SigmaM(double depth_m) const { return floor_m + growth_per_m * depth_m * depth_m; }
};

/// Returns the noise of typical cameras of a kind: structured light as Nguyen, Izadi and Lovell
/// (3DIMPVT 2012) measured for the first Kinect; stereo with a matching error of 0.08 pixels, a
/// focal length of 460 pixels and a baseline of 5 cm; time of flight as Tolgyessy et al. (Sensors
/// 2021) measured for the Azure Kinect.
DepthNoise NoiseOf(DepthSensorKind sensor);

}  // namespace steadymap
