#pragma once

#include <vector>

#include "core/frame/frame.h"

namespace steadymap::benchmarks {

/// The first `count` frames of the 7-Scenes kitchen in a z-up world, cropped to 640 x 360 pixels
/// around the middle, the size that every figure of the project is stated for. Reads the folder
/// `7scenes-kitchen` below the environment variable STEADYMAP_SHARED_DATA, or below the shared data
/// folder beside the checkout. Empty where there is none.
std::vector<Frame> LoadKitchenFrames(std::size_t count);

}  // namespace steadymap::benchmarks
