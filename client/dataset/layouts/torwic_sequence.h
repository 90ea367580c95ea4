#pragma once

#include "client/dataset/layouts/recorded_sequence.h"

namespace steadymap {

/// TorWIC-Mapping: a folder a sequence, with the images of one camera and its poses.
DatasetFormat TorwicFormat();

}  // namespace steadymap
