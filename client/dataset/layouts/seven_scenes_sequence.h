#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// 7-Scenes: a colour image, a depth image and a pose a frame.
DatasetFormat SevenScenesFormat();

}  // namespace steadymap
