#pragma once

#include <vector>

#include "core/frame/frame.h"

namespace steadymap::benchmarks {

/// Loads the first `count` frames of the 7-Scenes kitchen in a z-up world, cropped to the central
/// 640 x 360 pixels, the image size of all published measurements of the project. Reads the folder
/// `7scenes-kitchen` below the environment variable STEADYMAP_SHARED_DATA, or below the shared data
/// folder beside the checkout. Empty if the data set is missing.
std::vector<Frame> LoadKitchenFrames(std::size_t count);

}  // namespace steadymap::benchmarks
