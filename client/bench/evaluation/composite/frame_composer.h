#pragma once

#include <cstdint>

#include "client/bench/evaluation/room/room_case.h"
#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/sensor/renderer.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"

namespace steadymap {

/// Returns the errors of things that are drawn into frames of a structured-light camera: noise as
/// Nguyen, Izadi and Lovell (3DIMPVT 2012) measured for the first Kinect, partly correlated, and
/// its steps of disparity.
SensorModel StructuredLightModel();

/// Draws simulated things into recorded frames, as if they had stood there: a pixel shows the
/// nearer one of the thing and the recorded surface. Recorded surface in the shadow that a thing
/// casts, as seen from the sensor's projector, has no depth.
class FrameComposer {
 public:
  /// `things` must outlive the composer and not change. `camera` is that of all frames.
  FrameComposer(const Scene* things, const PinholeCamera& camera, const SensorModel& sensor);

  /// Draws the things into a frame, whose pose is taken as true. With labels, those of the frame
  /// are replaced: background but for the things. The noise depends on `noise_key` alone.
  void DrawInto(std::uint64_t noise_key, RoomLabels labels, Frame* frame);

  /// Returns the number of pixels in which the frame would show things.
  std::size_t CountVisible(const Frame& frame);

 private:
  void Shade(const Image<float>& thing_m, Frame* frame) const;

  SensorModel sensor_;
  PinholeCamera camera_;
  Renderer renderer_;
};

}  // namespace steadymap
