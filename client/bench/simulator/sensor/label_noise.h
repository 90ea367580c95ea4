#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"

namespace steadymap {

/// Returns the labelled class of `object` in a frame: its own, or a wrong one if the model's
/// whole-object flips select it in this frame. Objects without an instance are never flipped.
std::uint16_t ShownClass(const SensorModel& sensor,
                         std::uint64_t noise_key,
                         const SceneObject& object);

/// Adds wrong patches, then noise along the borders, if the model enables them.
void AddLabelNoise(const SensorModel& sensor,
                   std::uint64_t noise_key,
                   Image<std::uint16_t>* labels);

}  // namespace steadymap
