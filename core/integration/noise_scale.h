#pragma once

#include "core/frame/depth_sensor.h"
#include "core/frame/frame.h"

namespace steadymap {

/// Measures the noise of a depth image by the second differences along its rows, which are zero on
/// planes: returns the median of their magnitude, in that of `noise`. Edges and bends are few. 0
/// without measured depths. Noise that is correlated over more than two pixels is not measured.
double MeasureNoiseScale(const DepthImage& depth, const DepthNoise& noise);

}  // namespace steadymap
