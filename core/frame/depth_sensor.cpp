#include "core/frame/depth_sensor.h"

namespace steadymap {

DepthNoise NoiseOf(DepthSensorKind sensor) {
  switch (sensor) {
    case DepthSensorKind::kStructuredLight:
      return {0.001, 0.0019};
    case DepthSensorKind::kStereo:
      return {0.001, 0.0035};
    case DepthSensorKind::kTimeOfFlight:
      return {0.002, 0.0007};
    case DepthSensorKind::kLidar:
      return {0.015, 0.0};
    case DepthSensorKind::kUnknown:
      break;
  }
  return {0.001, 0.0025};
}

}  // namespace steadymap
