#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// Returns the TUM RGB-D format: lists of images and poses, which are matched by their times.
DatasetFormat TumFormat();

}  // namespace steadymap
