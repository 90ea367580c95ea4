#pragma once

#include <cstdint>

#include "client/bench/simulator/scene/scene.h"
#include "client/bench/simulator/sensor/sensor_model.h"
#include "core/frame/frame.h"

namespace steadymap {

/// The class that the labels of a frame show for `object`: its own, or a wrong one where the
/// model's whole-object flips hit it in this frame. Things without an instance are never flipped.
std::uint16_t ShownClass(const SensorModel& sensor,
                         std::uint64_t noise_key,
                         const SceneObject& object);

/// Adds wrong patches, then noise along the borders, as far as the model switches them on.
void AddLabelNoise(const SensorModel& sensor,
                   std::uint64_t noise_key,
                   Image<std::uint16_t>* labels);

}  // namespace steadymap
