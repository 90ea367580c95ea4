#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Returns the 7-Scenes format: a colour image, a depth image and a pose for each frame.
DatasetFormat SevenScenesFormat();

}  // namespace steadymap
